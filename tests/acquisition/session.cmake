set(acquisition_session_test_sources alignment_test.cpp part_characteristics_test.cpp part_frame_test.cpp first_touch_test.cpp hand_lap_test.cpp json_text_test.cpp live_section_test.cpp part_judge_test.cpp part_rows_test.cpp replay_pace_test.cpp run_results_test.cpp run_review_test.cpp sample_intake_test.cpp
    disk_room_test.cpp scan_job_again_test.cpp scan_job_align_test.cpp scan_job_hold_test.cpp scan_job_resume_test.cpp scan_job_retract_test.cpp scan_job_test.cpp scan_job_touch_test.cpp section_finisher_test.cpp section_gaps_test.cpp section_start_test.cpp session_test.cpp tolerance_watch_test.cpp
    touch_way_test.cpp workers_test.cpp)
list(TRANSFORM acquisition_session_test_sources PREPEND ${CMAKE_CURRENT_LIST_DIR}/)
find_package(nlohmann_json 3.11 REQUIRED)
cmm_test(acquisition_session_tests SOURCES ${acquisition_session_test_sources} LIBS cmm::acquisition nlohmann_json::nlohmann_json)
