set(ACQUISITION_SESSION_SOURCES event_payload.cpp first_touch.cpp hand_lap.cpp json_text.cpp live_section.cpp recorded_machine.cpp recording.cpp replay_machine.cpp replay_pace.cpp run_results.cpp sample_intake.cpp scan_job.cpp
    scan_job_hand.cpp scan_job_resume.cpp scan_job_unknown.cpp section_finisher.cpp section_setup.cpp section_start.cpp session.cpp)
