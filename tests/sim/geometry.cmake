cmm_test(sim_geometry_tests SOURCES contact_test.cpp mesh_test.cpp parametric_test.cpp LIBS cmm::sim)
