set(SIM_CONTROLLER_SOURCES
    controller.cpp controller_commands.cpp controller_faults.cpp controller_scan.cpp fault_plan.cpp fault_play.cpp faulty_wire.cpp line_codec.cpp line_protocol.cpp machine_file.cpp modbus_codec.cpp modbus_wire.cpp
    ramp.cpp register_bank.cpp register_map.cpp registers.cpp sample_fifo.cpp scan_path.cpp serial_line.cpp simulator.cpp
    travel.cpp truth_log.cpp wire_server.cpp)
