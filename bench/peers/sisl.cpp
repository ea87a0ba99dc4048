// SPDX-License-Identifier: Apache-2.0
#include <sisl.h>

#include "bench/peers/problem.hpp"

// SISL (AGPL): a program of its own, never part of the product.
using namespace cmm::bench::peers;

namespace {

void project(const std::string& folder, const std::string& order, SISLCurve* spline) {
    std::vector<double> queries = numbers(folder + "/queries." + order);
    std::vector<double> distances(queries.size() / 2);
    report("closest_" + order, time_ms(3, [&] {
               for (std::size_t i = 0; i < distances.size(); ++i) {
                   double parameter = 0.0;
                   int status = 0;
                   s1957(spline, &queries[2 * i], 2, 0.0, 1e-9, &parameter, &distances[i], &status);
                   if (status < 0) distances[i] = 1e300;
               }
           }));
    write(folder + "/sisl.closest_" + order, distances, 1);
}

void offset(const std::string& folder, SISLCurve* spline) {
    double normal[2] = {0.0, 0.0};
    SISLCurve* result = nullptr;
    report("offset_spline", time_ms(51, [&] {
               if (result != nullptr) freeCurve(result);
               result = nullptr;
               int status = 0;
               s1360(spline, -offset_mm, offset_tolerance_mm, normal, 0.0, 2, &result, &status);
           }));
    if (result == nullptr) return;
    const double from = result->et[result->ik - 1], to = result->et[result->in];
    std::vector<double> points;
    int left = 0;
    for (int i = 0; i < judged_points; ++i) {
        double at[2] = {0.0, 0.0};
        int status = 0;
        s1227(result, 0, from + (to - from) * i / judged_points, &left, at, &status);
        points.insert(points.end(), at, at + 2);
    }
    write(folder + "/sisl.offset_spline", points, 2);
    freeCurve(result);
}

}  // namespace

int main(int, char** arguments) {
    const std::string folder = arguments[1];
    std::printf("version SISL 4.6\n");
    Curve source = curve(folder);
    SISLCurve* spline =
        newCurve(static_cast<int>(source.count()), 4, source.knots.data(), source.controls.data(), 1, 2, 1);
    project(folder, "scan", spline);
    project(folder, "random", spline);
    offset(folder, spline);
    freeCurve(spline);
    return 0;
}
