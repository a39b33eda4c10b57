#include "mesher/tiles/fold_mender.h"

#include <algorithm>
#include <cstdlib>
#include <optional>

namespace hexrelief::mesh_tiles {
namespace {

// Finds the triangle to which a directed edge belongs, for edges with a wanted corner.
class EdgeIndex {
  public:
    EdgeIndex(const std::vector<Triangle>& triangles, const std::vector<bool>& is_wanted) {
        for (std::uint32_t t = 0; t < triangles.size(); ++t)
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t a = triangles[t][k], b = triangles[t][(k + 1) % 3];
                if (is_wanted[a] || is_wanted[b]) entries_.push_back({a, b, t});
            }
        std::sort(entries_.begin(), entries_.end());
    }
    std::optional<std::uint32_t> any_triangle_from(std::uint32_t corner) const {
        const auto found = std::lower_bound(entries_.begin(), entries_.end(), Triangle{corner, 0, 0});
        if (found == entries_.end() || (*found)[0] != corner) return std::nullopt;
        return (*found)[2];
    }
    std::optional<std::uint32_t> triangle_of(std::uint32_t from, std::uint32_t to) const {
        const auto found = std::lower_bound(entries_.begin(), entries_.end(), Triangle{from, to, 0});
        if (found == entries_.end() || (*found)[0] != from || (*found)[1] != to) return std::nullopt;
        return (*found)[2];
    }

  private:
    std::vector<Triangle> entries_;
};

class FoldMender {
  public:
    FoldMender(const TileMesh& mesh, std::vector<Triangle>& triangles) : mesh_(mesh), triangles_(triangles) {}

    // Returns the corners of triangles that are still degenerate or turned over.
    std::vector<std::uint32_t> mend() {
        constexpr int kRounds = 8;
        for (int round = 0; round < kRounds; ++round) {
            const std::vector<std::uint32_t> folds = find_folds();
            if (folds.empty()) return {};
            const EdgeIndex edges(triangles_, around(folds));
            touched_.assign(triangles_.size(), false);
            removed_.assign(triangles_.size(), false);
            bool has_changed = false;
            for (const std::uint32_t t : folds)
                if (!touched_[t]) has_changed |= mend(t, edges);
            std::uint32_t t = 0;
            std::erase_if(triangles_, [&](const Triangle&) { return removed_[t++]; });
            if (!has_changed) break;
        }
        std::vector<std::uint32_t> corners;
        for (const std::uint32_t t : find_folds())
            corners.insert(corners.end(), triangles_[t].begin(), triangles_[t].end());
        return corners;
    }

  private:
    std::vector<std::uint32_t> find_folds() const {
        std::vector<std::uint32_t> folds;
        for (std::uint32_t t = 0; t < triangles_.size(); ++t)
            if (twice_area(mesh_, triangles_[t]) <= 0) folds.push_back(t);
        return folds;
    }
    // Marks the corners of the folded triangles, and the corners next to these.
    std::vector<bool> around(const std::vector<std::uint32_t>& folds) const {
        std::vector<bool> is_of_fold(mesh_.corners.size());
        for (const std::uint32_t t : folds)
            for (const std::uint32_t v : triangles_[t]) is_of_fold[v] = true;
        std::vector<bool> is_near = is_of_fold;
        for (const Triangle& t : triangles_)
            if (is_of_fold[t[0]] || is_of_fold[t[1]] || is_of_fold[t[2]])
                for (const std::uint32_t v : t) is_near[v] = true;
        return is_near;
    }
    bool is_seam(std::uint32_t a, std::uint32_t b) const {
        return std::binary_search(mesh_.seam_edges.begin(), mesh_.seam_edges.end(),
                                  SeamEdge{mesh_.corners[a], mesh_.corners[b]});
    }
    // True if the edge from a to b has no triangle on its other side and is not a seam edge.
    bool is_open(const EdgeIndex& edges, std::uint32_t a, std::uint32_t b) const {
        return !edges.triangle_of(b, a) && !is_seam(a, b);
    }
    bool is_at_seam(const Triangle& t) const {
        return is_seam(t[0], t[1]) || is_seam(t[1], t[2]) || is_seam(t[2], t[0]);
    }
    // True if two corners of the triangle are at one place of the image.
    bool is_upright(const Triangle& t) const {
        const auto place = [&](std::uint32_t v) { return mesh_.corners[v].place; };
        return place(t[0]) == place(t[1]) || place(t[1]) == place(t[2]) || place(t[2]) == place(t[0]);
    }
    static bool is_edge(const EdgeIndex& edges, std::uint32_t a, std::uint32_t b) {
        return edges.triangle_of(a, b) || edges.triangle_of(b, a);
    }
    // Mends triangle t. Returns false if that is not possible.
    bool mend(std::uint32_t t, const EdgeIndex& edges) {
        const auto length = [&](std::size_t k) {
            const Place &a = mesh_.corners[triangles_[t][k]].place,
                        &b = mesh_.corners[triangles_[t][(k + 1) % 3]].place;
            return std::abs(std::int64_t{b.x} - a.x) + std::abs(std::int64_t{b.y} - a.y);
        };
        // The long side goes from r to p.
        std::size_t longest = 0;
        for (std::size_t k = 1; k < 3; ++k)
            if (length(k) > length(longest)) longest = k;
        const std::uint32_t r = triangles_[t][longest], p = triangles_[t][(longest + 1) % 3],
                            q = triangles_[t][(longest + 2) % 3];
        if (is_open(edges, r, p) || (is_open(edges, p, q) && is_open(edges, q, r)) ||
            (is_upright(triangles_[t]) && !is_at_seam(triangles_[t]))) {
            touched_[t] = removed_[t] = true;
            return true;
        }
        return flip(t, r, p, q, edges) || remove(q, edges) || remove(r, edges) || remove(p, edges);
    }
    // Flips the side from r to p of triangle t.
    bool flip(std::uint32_t t, std::uint32_t r, std::uint32_t p, std::uint32_t q, const EdgeIndex& edges) {
        const std::optional<std::uint32_t> other = edges.triangle_of(p, r);
        if (!other || touched_[*other]) return false;
        std::uint32_t s = triangles_[*other][0];
        for (const std::uint32_t v : triangles_[*other])
            if (v != p && v != r) s = v;
        const Triangle first = {p, q, s}, second = {q, r, s};
        if (twice_area(mesh_, first) <= 0 || twice_area(mesh_, second) <= 0 || is_edge(edges, q, s))
            return false;
        triangles_[t] = first;
        triangles_[*other] = second;
        touched_[t] = touched_[*other] = true;
        return true;
    }
    // Removes a corner with triangles all around it, and fills the hole with others.
    bool remove(std::uint32_t v, const EdgeIndex& edges) {
        constexpr std::size_t kMostAround = 24;
        std::vector<std::uint32_t> star, ring;
        std::optional<std::uint32_t> at = edges.any_triangle_from(v);
        while (at && !touched_[*at] && ring.size() < kMostAround) {
            const Triangle& t = triangles_[*at];
            const std::size_t k = t[0] == v ? 0 : t[1] == v ? 1 : 2;
            star.push_back(*at);
            ring.push_back(t[(k + 1) % 3]);
            at = edges.triangle_of(v, t[(k + 2) % 3]);
            if (at == star.front()) break;
        }
        if (star.empty() || at != star.front()) return false;
        const std::vector<Triangle> filling = filled(ring, edges);
        if (filling.empty()) return false;
        for (std::size_t k = 0; k < star.size(); ++k) {
            touched_[star[k]] = true;
            if (k < filling.size())
                triangles_[star[k]] = filling[k];
            else
                removed_[star[k]] = true;
        }
        return true;
    }
    // Triangulates a polygon by ear clipping; returns no triangles if that is not possible.
    std::vector<Triangle> filled(std::vector<std::uint32_t> ring, const EdgeIndex& edges) const {
        std::vector<Triangle> filling;
        while (ring.size() >= 3) {
            const std::size_t n = ring.size();
            std::size_t k = 0;
            for (; k < n; ++k) {
                const Triangle ear = {ring[(k + n - 1) % n], ring[k], ring[(k + 1) % n]};
                if (twice_area(mesh_, ear) <= 0 || (n > 3 && is_edge(edges, ear[0], ear[2]))) continue;
                if (std::none_of(ring.begin(), ring.end(),
                                 [&](std::uint32_t v) { return is_within(v, ear); })) {
                    filling.push_back(ear);
                    break;
                }
            }
            if (k == n) return {};
            ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(k));
        }
        return filling;
    }
    // True if v lies within the triangle or on its border and is not one of its corners.
    bool is_within(std::uint32_t v, const Triangle& t) const {
        return v != t[0] && v != t[1] && v != t[2] && twice_area(mesh_, {t[0], t[1], v}) >= 0 &&
               twice_area(mesh_, {t[1], t[2], v}) >= 0 && twice_area(mesh_, {t[2], t[0], v}) >= 0;
    }

    const TileMesh& mesh_;
    std::vector<Triangle>& triangles_;
    std::vector<bool> touched_, removed_;  // in the current round
};

}  // namespace

std::int64_t twice_area(const TileMesh& mesh, const Triangle& t) {
    const Place &a = mesh.corners[t[0]].place, &b = mesh.corners[t[1]].place, &c = mesh.corners[t[2]].place;
    return (std::int64_t{b.x} - a.x) * (std::int64_t{c.y} - a.y) -
           (std::int64_t{b.y} - a.y) * (std::int64_t{c.x} - a.x);
}

std::vector<std::uint32_t> mend_folds(const TileMesh& mesh, std::vector<Triangle>& triangles) {
    return FoldMender(mesh, triangles).mend();
}

}  // namespace hexrelief::mesh_tiles
