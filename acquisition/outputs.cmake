# What is kept, judged and goes out: journal, evaluation, files, report.
set(ACQUISITION_OUTPUT_SOURCES
    alignment.cpp asked_characteristics.cpp budget_table.cpp characteristic.cpp characteristic_table.cpp curvature_extreme.cpp decision_rule.cpp
    deviation_chart.cpp deviation_map.cpp evaluation.cpp events.cpp export_csv.cpp export_dfq.cpp export_dmis.cpp export_json.cpp export_pdf.cpp export_qif.cpp exports.cpp figure_layout.cpp gauge_anova.cpp gauge_figure.cpp gauge_numbers.cpp gauge_report.cpp gauge_study.cpp gauge_text.cpp html.cpp journal.cpp listed_characteristic.cpp nominal_measures.cpp operator_choice.cpp part_body.cpp part_rows.cpp part_characteristics.cpp plot_frame.cpp point_tolerance.cpp points_out.cpp profile.cpp
    reference_contour.cpp report.cpp report_style.cpp report_text.cpp run_file.cpp sample_codec.cpp section_alignment.cpp section_figures.cpp section_result.cpp section_sizes.cpp span_point.cpp summary.cpp surface_deviation.cpp svg.cpp
    traceability.cpp trend_chart.cpp unit.cpp whisker_chart.cpp worst_place.cpp writer_lock.cpp zone_set.cpp)
