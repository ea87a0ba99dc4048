cmm_test(acquisition_session_tests SOURCES session_test.cpp LIBS cmm::acquisition)
