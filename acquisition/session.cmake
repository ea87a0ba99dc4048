set(ACQUISITION_SESSION_SOURCES event_payload.cpp json_text.cpp live_section.cpp run_results.cpp sample_intake.cpp scan_job.cpp
    section_finisher.cpp section_setup.cpp session.cpp)
