// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "fitting/newton_foot.hpp"
#include "fitting/surface.hpp"
#include "fitting/surface_patch.hpp"

namespace cmm::fitting {

/// Finds the nearest point of the whole surface, to half a nanometre of distance, with proof: patches are skipped only
/// when a certified bound says that nothing of them is nearer (box; parallelogram and deviation), settled by Newton's
/// method where |S - p|^2 is certified to be convex, and split otherwise (docs/theory.md, "Surfaces"). A hint makes it
/// faster and changes nothing else. Refers to the surface, which must outlive it. Immutable, any thread.
class SurfaceIndex {
  public:
    explicit SurfaceIndex(const Surface& surface);

    /// A point that is not finite gets the surface's start and an infinite squared distance.
    SurfaceFoot closest(const Vec3& p, const std::optional<SurfacePlace>& hint = {}, SearchCost* cost = nullptr) const;

    /// For many points in any order: those that jump about are visited cell by cell, so that neighbours follow each
    /// other. `feet` has room for as many.
    void closest(std::span<const Vec3> points, std::span<SurfaceFoot> feet, SearchCost* cost = nullptr) const;

  private:
    static constexpr std::uint32_t group_size = PatchGroup::size, most_groups_at_once = 32;
    /// Single precision, of which twice as many lanes hold.
    using Lanes = PatchGroup::Lanes;
    /// A point in single precision: between which numbers it lies, and by how much what is reckoned with it may be off.
    struct Rounded {
        Rounded(const Vec3& p, double extent);
        std::array<float, 3> low, high, middle;
        float slack;
    };
    /// Boxes, rounded outwards.
    struct Group {
        Lanes low[3], high[3];
        Lanes squares(const Rounded& p) const;  // of the distances to them
    };
    struct Undecided {
        double least;
        PatchBounds patch;
    };
    static constexpr double nothing_yet = std::numeric_limits<double>::infinity();
    struct Best {
        SurfaceFoot foot;
        double distance = nothing_yet;
        double limit = nothing_yet;                                    // what is not nearer than this does not matter
        float limit_above = std::numeric_limits<float>::infinity();    // in single precision, rounding included
        float limit_squared = std::numeric_limits<float>::infinity();  // the same
        bool stationary = false;  // the foot is a minimum of its own, not the end of a patch
        SearchCost cost = {};
        std::vector<Undecided> undecided = {};  // a heap, the nearest first
        void take(const SurfaceFoot& found, bool minimum);
    };
    void add_patches(const PatchDomain& domain, int depth);
    void bring_neighbours_together();
    void build_tree();
    SurfaceFoot foot_of(const Vec3& p, const std::optional<SurfacePlace>& hint, SurfaceSpans& near,
                        SearchCost* cost) const;
    std::vector<std::uint32_t> neighbours_first(std::span<const Vec3> points) const;
    void approach(const Vec3& p, const Rounded& rounded, Best& best) const;
    void search(const Vec3& p, const Rounded& rounded, std::size_t level, std::span<const std::uint32_t> groups,
                Best& best) const;
    void look_at(const Vec3& p, const Rounded& rounded, std::span<const std::uint32_t> groups, Best& best) const;
    std::uint32_t filled(std::uint32_t group) const;
    void visit(const Vec3& p, const PatchBounds& patch, Best& best) const;
    void settle(const Vec3& p, Best& best) const;
    void sound(const Vec3& p, const PatchDomain& domain, Best& best) const;
    void minimise(const Vec3& p, const PatchDomain& domain, Best& best) const;

    const Surface& surface_;
    std::vector<PatchBounds> patches_;
    std::vector<PatchGroup> groups_;
    std::vector<std::vector<Group>> levels_;  // boxes of the groups, of these by eight, and so on to one
    std::uint32_t in_last_group_ = 0;         // a bit for each patch that it has
    double extent_ = 0.0;                     // no coordinate is larger
};

}  // namespace cmm::fitting
