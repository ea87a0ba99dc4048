cmm_test(sim_controller_tests
    SOURCES controller_rig.cpp controller_scan_test.cpp controller_test.cpp foreign_client_test.cpp ramp_test.cpp
            scan_path_test.cpp served_bar.cpp travel_test.cpp
    LIBS cmm::sim Threads::Threads)
