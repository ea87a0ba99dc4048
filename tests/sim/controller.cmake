cmm_test(sim_controller_tests
    SOURCES controller_faults_test.cpp controller_rig.cpp controller_scan_test.cpp controller_test.cpp fault_plan_test.cpp faulty_wire_test.cpp foreign_client_test.cpp line_protocol_test.cpp machine_file_test.cpp
            modbus_codec_test.cpp modbus_wire_test.cpp wire_server_test.cpp ramp_test.cpp register_bank_test.cpp registers_test.cpp
            sample_fifo_test.cpp scan_path_test.cpp simulator_test.cpp served_bar.cpp travel_test.cpp truth_log_test.cpp wire_client.cpp
            ${PROJECT_SOURCE_DIR}/tests/support/serial_wire.cpp
    LIBS cmm::sim Threads::Threads)
