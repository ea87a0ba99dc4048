cmm_test(sim_geometry_tests SOURCES contact_test.cpp loft_test.cpp machine_error_test.cpp mesh_file_test.cpp mesh_test.cpp parametric_test.cpp
    part_test.cpp probe_test.cpp section_cut_test.cpp section_file_test.cpp LIBS cmm::sim)
