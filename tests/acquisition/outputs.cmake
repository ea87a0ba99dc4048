find_package(nlohmann_json 3.11 REQUIRED)
cmm_test(acquisition_outputs_tests
    SOURCES asked_characteristics_test.cpp characteristic_table_test.cpp decision_rule_test.cpp evaluation_test.cpp events_test.cpp export_dfq_test.cpp export_dmis_test.cpp export_qif_test.cpp exports_test.cpp gauge_anova_test.cpp gauge_study_test.cpp journal_test.cpp nominal_measures_test.cpp operator_choice_test.cpp point_tolerance_test.cpp points_out_test.cpp recorded_machine_test.cpp sample_codec_test.cpp svg_test.cpp traceability_test.cpp
    LIBS cmm::acquisition SQLite::SQLite3 nlohmann_json::nlohmann_json)
# What decisions risk, with simulated blades through the whole fit.
cmm_test(decision_risk_tests
    SOURCES decision_risk_test.cpp decision_subject.cpp decision_trials.cpp measure_again_test.cpp natural_noses_test.cpp stray_sections_test.cpp until_decided_trials.cpp
        ${PROJECT_SOURCE_DIR}/tests/fitting/support/drawn_errors.cpp
        ${PROJECT_SOURCE_DIR}/tests/fitting/support/exact_sections.cpp
        ${PROJECT_SOURCE_DIR}/tests/fitting/support/families.cpp
        ${PROJECT_SOURCE_DIR}/tests/fitting/support/family_scan.cpp
        ${PROJECT_SOURCE_DIR}/tests/fitting/support/natural_blade.cpp
        ${PROJECT_SOURCE_DIR}/tests/fitting/support/section_truth.cpp
        ${PROJECT_SOURCE_DIR}/tests/fitting/support/twisted_blade.cpp
    LIBS cmm::acquisition TIMEOUT 300)
target_include_directories(decision_risk_tests PRIVATE ${PROJECT_SOURCE_DIR}/tests/fitting)
# Contours of simulated blades over many seeds, a table: built and run by hand.
add_executable(families_sweep EXCLUDE_FROM_ALL families_sweep.cpp
    ${PROJECT_SOURCE_DIR}/tests/fitting/support/exact_sections.cpp
    ${PROJECT_SOURCE_DIR}/tests/fitting/support/families.cpp
    ${PROJECT_SOURCE_DIR}/tests/fitting/support/family_scan.cpp
    ${PROJECT_SOURCE_DIR}/tests/fitting/support/twisted_blade.cpp)
target_link_libraries(families_sweep PRIVATE cmm::acquisition cmm_options)
target_include_directories(families_sweep PRIVATE ${PROJECT_SOURCE_DIR}/tests/fitting)
# Curvatures of simulated blades through the whole fit.
cmm_test(curvature_tests
    SOURCES curvature_extreme_test.cpp
        ${PROJECT_SOURCE_DIR}/tests/fitting/support/families.cpp
        ${PROJECT_SOURCE_DIR}/tests/fitting/support/family_scan.cpp
    LIBS cmm::acquisition TIMEOUT 300)
target_include_directories(curvature_tests PRIVATE ${PROJECT_SOURCE_DIR}/tests/fitting)
