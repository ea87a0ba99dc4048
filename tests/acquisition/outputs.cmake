cmm_test(acquisition_outputs_tests
    SOURCES journal_test.cpp sample_codec_test.cpp
    LIBS cmm::acquisition SQLite::SQLite3)
