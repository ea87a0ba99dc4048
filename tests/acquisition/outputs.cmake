find_package(nlohmann_json 3.11 REQUIRED)
cmm_test(acquisition_outputs_tests
    SOURCES asked_characteristics_test.cpp evaluation_test.cpp events_test.cpp export_dfq_test.cpp export_qif_test.cpp exports_test.cpp journal_test.cpp operator_choice_test.cpp recorded_machine_test.cpp sample_codec_test.cpp svg_test.cpp
    LIBS cmm::acquisition SQLite::SQLite3 nlohmann_json::nlohmann_json)
