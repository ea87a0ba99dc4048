// SPDX-License-Identifier: Apache-2.0
#include <sisl.h>

#include <cmath>

#include "bench/peers/problem.hpp"

// SISL (AGPL): a program of its own, never part of the product.
using namespace cmm::bench::peers;

namespace {

/// Newton's method from the foot of the point before.
void project(const std::string& folder, const std::string& order, SISLSurf* surface) {
    std::vector<double> queries = numbers(folder + "/queries." + order), distances(queries.size() / 3);
    double start[2] = {surface->et1[surface->ik1 - 1], surface->et2[surface->ik2 - 1]};
    double end[2] = {surface->et1[surface->in1], surface->et2[surface->in2]};
    report("closest_" + order + "_warm", time_ms(3, [&] {
               double last[2] = {0.5 * (start[0] + end[0]), 0.5 * (start[1] + end[1])};
               for (std::size_t i = 0; i < distances.size(); ++i) {
                   double foot[2] = {0.0, 0.0}, at[9] = {};
                   int status = 0, left1 = 0, left2 = 0;
                   s1775(surface, &queries[3 * i], 3, 1e-9, start, end, last, foot, &status);
                   distances[i] = 1e300;
                   if (status < 0) continue;
                   int evaluated = 0;
                   double normal[3];
                   s1421(surface, 0, foot, &left1, &left2, at, normal, &evaluated);
                   distances[i] =
                       std::hypot(at[0] - queries[3 * i], at[1] - queries[3 * i + 1], at[2] - queries[3 * i + 2]);
                   last[0] = foot[0];
                   last[1] = foot[1];
               }
           }));
    write(folder + "/sisl.closest_" + order + "_warm", distances, 1);
}

}  // namespace

int main(int, char** arguments) {
    const std::string folder = arguments[1];
    std::printf("version SISL 4.6\n");
    std::vector<double> u = numbers(folder + "/surface.knots_u"), v = numbers(folder + "/surface.knots_v"),
                        controls = numbers(folder + "/surface.controls");
    SISLSurf* surface = newSurf(static_cast<int>(u.size()) - 4, static_cast<int>(v.size()) - 4, 4, 4, u.data(),
                                v.data(), controls.data(), 1, 3, 1);
    project(folder, "scan", surface);
    project(folder, "random", surface);
    freeSurf(surface);
    return 0;
}
