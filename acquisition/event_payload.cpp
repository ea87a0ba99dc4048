// SPDX-License-Identifier: Apache-2.0
#include "acquisition/event_payload.hpp"

#include "acquisition/json_text.hpp"
#include "core/text.hpp"

namespace cmm::acquisition {
namespace {

constexpr int count_digits = 4;  // a tenth of a micrometre: the controller's count
constexpr int fine_digits = 6;
constexpr int number_digits = 9;  // a nanometre, and as much of an angle on a metre

std::string_view to_string(LiveSnapshot::State state) {
    switch (state) {
        case LiveSnapshot::State::empty:
            return "empty";
        case LiveSnapshot::State::open:
            return "open";
        case LiveSnapshot::State::closed:
            return "closed";
    }
    return "empty";
}

std::optional<double> known(bool valid, double value) {
    return valid ? std::optional(value) : std::nullopt;
}

JsonFields& add_time(JsonFields& fields, const std::optional<TimeTaken>& taken) {
    const auto if_taken = [&](double TimeTaken::*ms) { return taken ? std::optional((*taken).*ms) : std::nullopt; };
    return fields.add("latency_ms", if_taken(&TimeTaken::latency_ms), 3)
        .add("processor_ms", if_taken(&TimeTaken::processor_ms), 3);
}

std::string with_characteristic(JsonFields& fields, const Characteristic& characteristic) {
    return fields.add("name", characteristic.name)
        .add("value_mm", in_mm(characteristic, characteristic.value), fine_digits)
        .add("u95_mm", in_mm(characteristic, characteristic.u95), fine_digits)
        .add("limit_mm", in_mm(characteristic, characteristic.upper), fine_digits)
        .add("unit", acquisition::to_string(characteristic.unit))
        .add("value", characteristic.value, number_digits)
        .add("u95", characteristic.u95, number_digits)
        .add("nominal", characteristic.nominal, number_digits)
        .add("lower", characteristic.lower, number_digits)
        .add("upper", characteristic.upper, number_digits)
        .add("decision", acquisition::to_string(characteristic.decision))
        .add("method", characteristic.method)
        .text();
}

}  // namespace

std::string batch_payload(std::size_t section, std::uint64_t first_sequence, std::size_t count) {
    return JsonFields().add("section", section).add("first_seq", first_sequence).add("count", count).text();
}

std::string snapshot_payload(std::size_t section, const LiveSnapshot& snapshot) {
    return JsonFields()
        .add("section", section)
        .add("state", to_string(snapshot.state))
        .add("points", snapshot.points)
        .add("no_contact", snapshot.no_contact)
        .add("length_mm", snapshot.length_mm, 3)
        .add("x_mm", snapshot.last_mm.x(), count_digits)
        .add("y_mm", snapshot.last_mm.y(), count_digits)
        .add("z_mm", snapshot.last_mm.z(), count_digits)
        .add("worst_deviation_mm", snapshot.worst_deviation_mm, count_digits)
        .add("curvature_per_mm", known(snapshot.curve.valid, snapshot.curve.curvature), fine_digits)
        .add("doubtful", snapshot.curve.doubtful)
        .add("noise_mm", known(snapshot.curve.valid, snapshot.noise_mm), fine_digits)
        .add("next_x_mm", known(snapshot.predicted.valid, snapshot.predicted.centre.x()), count_digits)
        .add("next_y_mm", known(snapshot.predicted.valid, snapshot.predicted.centre.y()), count_digits)
        .add("next_sigma_mm", known(snapshot.predicted.valid, snapshot.predicted.sigma_mm), fine_digits)
        .text();
}

std::string final_payload(const SectionResult& section, const std::optional<TimeTaken>& taken) {
    JsonFields fields;
    fields.add("section", section.index)
        .add("z_mm", section.z_mm, count_digits)
        .add("points", section.points.size())
        .add("rejected", section.fit ? section.fit->rejected : 0)
        .add("closed", section.all_round());
    add_time(fields, taken)
        .add("compensation", acquisition::to_string(section.compensation.state))
        .add("method", fitting::to_string(section.compensation.method()))
        .add("alignment", acquisition::to_string(section.alignment.state));
    if (!section.all_round()) fields.add("why", section.why_not_all_round());
    return fields.text();
}

std::string revised_payload(const SectionResult& section) {
    const Compensation& compensation = section.compensation;
    JsonFields fields;
    fields.add("section", section.index)
        .add("z_mm", section.z_mm, count_digits)
        .add("compensation", acquisition::to_string(compensation.state))
        .add("method", fitting::to_string(compensation.method()))
        .add("alignment", acquisition::to_string(section.alignment.state))
        .add("share", compensation.share, count_digits)
        .add("change_mm", compensation.change_mm, fine_digits)
        .add("from_2d_mm", compensation.from_flat_mm, fine_digits);
    if (!compensation.note.empty()) fields.add("why", compensation.note);
    return fields.text();
}

std::string rejected_payload(std::size_t section, const RecordedPoint& point) {
    return JsonFields()
        .add("section", section)
        .add("sample", point.sequence)
        .add("residual_mm", point.verdict.residual_mm, count_digits)
        .add("reason", fitting::to_string(point.verdict.reason))
        .text();
}

std::string restored_payload(std::size_t section, const RecordedPoint& point) {
    return JsonFields().add("section", section).add("sample", point.sequence).text();
}

std::string characteristic_payload(std::size_t section, const Characteristic& characteristic) {
    return with_characteristic(JsonFields().add("section", section), characteristic);
}

std::string characteristic_payload(const PartCharacteristic& characteristic) {
    JsonFields fields;
    fields.raw("section", characteristic.section ? std::to_string(*characteristic.section) : "null")
        .add("of_part", true);
    return with_characteristic(fields, characteristic.number);
}

std::string exceedance_payload(std::size_t section, const Exceedance& exceedance, double latency_ms) {
    return JsonFields()
        .add("section", section)
        .add("decision", acquisition::to_string(Decision::reject))
        .add("while_measuring", true)
        .add("zone", fitting::to_string(exceedance.zone))
        .add("sample", exceedance.sequence)
        .add("deviation_mm", exceedance.deviation_mm, fine_digits)
        .add("guard_mm", exceedance.guard_mm, fine_digits)
        .add("limit_mm", exceedance.limit_mm, fine_digits)
        .add("latency_ms", latency_ms, 3)
        .text();
}

std::string again_payload(const SectionResult& section, std::size_t pass, const AgainPass& planned) {
    std::string because;
    for (const auto& name : planned.because) {
        const auto* c = section.find(name);
        because += (because.empty() ? "{" : ",{") +
                   JsonFields()
                       .add("name", name)
                       .add("value", c->value, number_digits)
                       .add("u95", c->u95, number_digits)
                       .add("lower", c->lower, number_digits)
                       .add("upper", c->upper, number_digits)
                       .text() +
                   "}";
    }
    return JsonFields()
        .add("section", section.index)
        .add("z_mm", section.z_mm, 4)
        .add("pass", pass)
        .add("points", planned.points())
        .add("stretches", planned.stretches.size())
        .add("seconds", planned.duration_s, 1)
        .raw("because", "[" + because + "]")
        .text();
}

std::string decision_payload(std::size_t section, Decision decision, bool certain,
                             const std::optional<TimeTaken>& taken) {
    JsonFields fields;
    fields.add("section", section).add("decision", acquisition::to_string(decision)).add("certain", certain);
    return add_time(fields, taken).text();
}

std::string frame_payload(const PartFrame& frame) {
    const auto list = [](const auto& values, int digits) {
        std::string text;
        for (const double value : values)
            text += (text.empty() ? "[" : ", ") + core::fixed(value, digits);
        return text + "]";
    };
    std::string excesses;
    for (const auto& excess : frame.excess_mm)
        excesses += (excesses.empty() ? "[" : ", ") + (excess ? core::fixed(*excess, number_digits) : "null");
    return JsonFields()
        .add("kind", acquisition::to_string(AlignmentKind::six_points))
        .add("rounds", frame.rounds)
        .add("condition", frame.condition, 3)
        .raw("about_mm", list(frame.about_mm, number_digits))
        .raw("shift_mm", list(frame.shift_mm(), number_digits))
        .raw("turn_rad", list(frame.turn_rad(), number_digits))
        .raw("standard", list(frame.standard(), number_digits))
        .raw("residual_mm", list(frame.residual_mm, number_digits))
        .raw("excess_mm", excesses + "]")
        .add("moved_mm", frame.moved_mm, number_digits)
        .text();
}

std::string link_payload(const drivers::LinkStats& stats) {
    JsonFields fields;
    fields.add("exchanges", stats.ok)
        .add("errors", stats.errors())
        .add("retries", stats.retries)
        .add("reconnects", stats.reconnects)
        .add("bytes_received", stats.bytes_received)
        .add("mean_round_trip_ms",
             stats.ok > 0 ? stats.total_round_trip_us * 1e-3 / static_cast<double>(stats.ok) : 0.0, 4)
        .add("max_round_trip_ms", stats.max_round_trip_us * 1e-3, 3);
    if (!stats.note.empty()) fields.add("note", stats.note);
    return fields.text();
}

}  // namespace cmm::acquisition
