// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "acquisition/file_number.hpp"
#include "acquisition/plan.hpp"

namespace cmm::acquisition {
namespace {

using core::ErrorCode;
using core::fail;
using Json = nlohmann::ordered_json;

constexpr const char* schema_name = "cmmlive-plan";

template <class Vector>
Json numbers(const Vector& vector) {
    Json list = Json::array();
    for (const double value : vector)
        list.push_back(file_number(value));
    return list;
}

template <int N>
Eigen::Matrix<double, N, 1> vector_from(const Json& list) {
    if (list.size() != N)
        throw Json::other_error::create(501, "a list of " + std::to_string(N) + " numbers is expected", &list);
    Eigen::Matrix<double, N, 1> vector;
    for (int i = 0; i < N; ++i)
        vector[i] = list.at(static_cast<std::size_t>(i)).get<double>();
    return vector;
}

/// x y z nx ny nz speed record
Json point_to_json(const drivers::PathPoint& point) {
    Json row = numbers(point.centre_mm);
    for (const double n : point.normal)
        row.push_back(file_number(n));
    row.push_back(file_number(point.speed_mm_s));
    row.push_back(point.record ? 1 : 0);
    return row;
}

drivers::PathPoint point_from_json(const Json& row) {
    const auto values = vector_from<8>(row);
    return {values.head<3>(), values.segment<3>(3), values[6], values[7] != 0.0};
}

Json path_to_json(const PlannedPath& path) {
    Json json{{"section", path.section},
              {"z_mm", file_number(path.z_mm)},
              {"length_mm", file_number(path.length_mm)},
              {"duration_s", file_number(path.duration_s)}};
    if (path.start_mm) json["start_mm"] = numbers(*path.start_mm);
    if (path.toward_mm) json["toward_mm"] = numbers(*path.toward_mm);
    json["approach_route_mm"] = Json::array();
    for (const auto& point : path.approach_route)
        json["approach_route_mm"].push_back(numbers(point));
    json["unreached"] = Json::array();
    for (const auto& place : path.unreached) {
        json["unreached"].push_back(
            {{"position_mm", numbers(place.position_mm)}, {"depth_mm", file_number(place.depth_mm)}});
    }
    json["points"] = Json::array();
    for (const auto& point : path.points)
        json["points"].push_back(point_to_json(point));
    return json;
}

PlannedPath path_from_json(const Json& json) {
    PlannedPath path;
    path.section = json.at("section").get<std::size_t>();
    path.z_mm = json.at("z_mm").get<double>();
    path.length_mm = json.at("length_mm").get<double>();
    path.duration_s = json.at("duration_s").get<double>();
    if (json.contains("start_mm")) path.start_mm = vector_from<2>(json.at("start_mm"));
    if (json.contains("toward_mm")) path.toward_mm = vector_from<2>(json.at("toward_mm"));
    for (const auto& point : json.at("approach_route_mm"))
        path.approach_route.emplace_back(vector_from<3>(point));
    for (const auto& place : json.at("unreached")) {
        path.unreached.push_back({vector_from<2>(place.at("position_mm")), place.at("depth_mm").get<double>()});
    }
    for (const auto& row : json.at("points"))
        path.points.push_back(point_from_json(row));
    return path;
}

Json clearance_to_json(const Clearance& clearance) {
    Json json{{"low_mm", numbers(clearance.low_mm)}, {"high_mm", numbers(clearance.high_mm)}};
    const auto& stylus = clearance.stylus;
    json["stylus"] = {
        {"radius_mm", stylus.radius_mm}, {"shank_radius_mm", stylus.shank_radius_mm}, {"length_mm", stylus.length_mm}};
    if (!clearance.obstacles.empty()) json["top_mm"] = file_number(clearance.top_mm);
    if (clearance.way_out) json["way_out"] = numbers(*clearance.way_out);
    json["obstacles"] = Json::array();
    for (const auto& obstacle : clearance.obstacles) {
        Json outline = Json::array();
        for (const auto& point : obstacle.outline)
            outline.push_back(numbers(point));
        json["obstacles"].push_back({{"z_mm", file_number(obstacle.z_mm)}, {"outline_mm", std::move(outline)}});
    }
    return json;
}

Clearance clearance_from_json(const Json& json) {
    Clearance clearance;
    clearance.low_mm = vector_from<2>(json.at("low_mm"));
    clearance.high_mm = vector_from<2>(json.at("high_mm"));
    const auto& stylus = json.at("stylus");
    clearance.stylus = {stylus.at("radius_mm").get<double>(), stylus.at("shank_radius_mm").get<double>(),
                        stylus.at("length_mm").get<double>()};
    clearance.top_mm = json.contains("top_mm") ? json.at("top_mm").get<double>() : std::numeric_limits<double>::max();
    if (json.contains("way_out")) clearance.way_out = vector_from<2>(json.at("way_out"));
    for (const auto& item : json.at("obstacles")) {
        Obstacle obstacle{item.at("z_mm").get<double>(), {}};
        for (const auto& point : item.at("outline_mm"))
            obstacle.outline.emplace_back(vector_from<2>(point));
        clearance.obstacles.push_back(std::move(obstacle));
    }
    return clearance;
}

Json to_json_without_hash(const Plan& plan) {
    Json json{{"schema", schema_name}, {"schema_version", Plan::schema_version}, {"part", plan.part_name}};
    json["approach_mm"] = file_number(plan.approach_mm);
    json["search_mm"] = file_number(plan.search_mm);
    json["travel_speed_mm_s"] = file_number(plan.travel_speed_mm_s);
    json["approach_speed_mm_s"] = file_number(plan.approach_speed_mm_s);
    json["length_mm"] = file_number(plan.length_mm);
    json["duration_s"] = file_number(plan.duration_s);
    json["clearance"] = clearance_to_json(plan.clearance);
    if (!plan.datum_touches.empty()) {
        json["datum_approach_mm"] = file_number(plan.datum_approach_mm);
        json["datum_search_mm"] = file_number(plan.datum_search_mm);
        json["datum_touches"] = Json::array();
        for (const auto& point : plan.datum_touches)
            json["datum_touches"].push_back(point_to_json(point));
        // Absent without middles: the hash of such a plan is that of plans before there were any.
        if (plan.datum_middles != DatumMiddles{}) json["datum_middles"] = plan.datum_middles;
    }
    json["paths"] = Json::array();
    for (const auto& path : plan.paths)
        json["paths"].push_back(path_to_json(path));
    return json;
}

Plan from_json(const Json& json) {
    Plan plan;
    plan.part_name = json.at("part").get<std::string>();
    plan.approach_mm = json.at("approach_mm").get<double>();
    plan.search_mm = json.at("search_mm").get<double>();
    plan.travel_speed_mm_s = json.at("travel_speed_mm_s").get<double>();
    plan.approach_speed_mm_s = json.at("approach_speed_mm_s").get<double>();
    plan.length_mm = json.at("length_mm").get<double>();
    plan.duration_s = json.at("duration_s").get<double>();
    plan.clearance = clearance_from_json(json.at("clearance"));
    if (json.contains("datum_touches")) {
        plan.datum_approach_mm = json.at("datum_approach_mm").get<double>();
        plan.datum_search_mm = json.at("datum_search_mm").get<double>();
        for (const auto& row : json.at("datum_touches"))
            plan.datum_touches.push_back(point_from_json(row));
        plan.datum_middles = json.value("datum_middles", DatumMiddles{});
    }
    for (const auto& path : json.at("paths"))
        plan.paths.push_back(path_from_json(path));
    plan.hash = json.at("hash").get<std::string>();
    return plan;
}

}  // namespace

std::string plan_hash(const Plan& plan) {
    // FNV-1a, 64 bits: tells plans apart, guards against nobody.
    std::uint64_t hash = 14695981039346656037ULL;
    for (const char c : to_json_without_hash(plan).dump())
        hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ULL;
    std::array<char, 17> text{};
    std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(hash));
    return text.data();
}

std::string plan_to_text(const Plan& plan) {
    Json json = to_json_without_hash(plan);
    json["hash"] = plan.hash;
    return json.dump(1) + "\n";
}

core::Result<Plan> parse_plan(std::string_view text, const std::string& name) {
    try {
        const Json json = Json::parse(text);
        if (json.value("schema", "") != schema_name)
            return fail(ErrorCode::config_invalid, name + ": not a plan of cmmlive");
        if (json.value("schema_version", 0) != Plan::schema_version) {
            return fail(ErrorCode::config_invalid,
                        name + ": schema_version is not " + std::to_string(Plan::schema_version));
        }
        Plan plan = from_json(json);
        if (plan.hash != plan_hash(plan)) {
            return fail(ErrorCode::config_invalid,
                        name + ": the hash does not fit the plan: it was changed by hand; plan anew");
        }
        return plan;
    } catch (const Json::parse_error& error) {
        return fail(ErrorCode::config_syntax, name + ": " + error.what());
    } catch (const Json::exception& error) {
        return fail(ErrorCode::config_invalid, name + ": " + error.what());
    }
}

}  // namespace cmm::acquisition
