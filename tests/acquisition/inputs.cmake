set(acquisition_inputs_test_sources nom_file_test.cpp nominal_test.cpp part_file_test.cpp plan_test.cpp plan_times_test.cpp points_file_test.cpp profile_starts_test.cpp six_point_spec_test.cpp tol_file_test.cpp triangle_mesh_test.cpp uncertainty_spec_test.cpp unknown_scan_test.cpp)
list(TRANSFORM acquisition_inputs_test_sources PREPEND ${CMAKE_CURRENT_LIST_DIR}/)
cmm_test(acquisition_inputs_tests SOURCES ${acquisition_inputs_test_sources} LIBS cmm::acquisition)
