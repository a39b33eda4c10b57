#include "mesher/surface/topology/split_triangles.h"

#include "mesher/surface/pixels/crack_query.h"
#include "pipeline/base/thread_team.h"

namespace hexrelief::surface {
namespace {

using View = step::SplitView<std::array<std::int32_t, 3>*>;
using Splitter = step::LatticeSplitter<View>;

View view_of(SplitLattice& lattice) {
    return {lattice.points.data(), lattice.triangles.data(), lattice.neighbours.data(),
            lattice.changed.data()};
}

void resize(SplitLattice& lattice, const step::LatticeCounts& counts) {
    lattice.points.resize(counts.points);
    lattice.triangles.resize(counts.triangles);
    lattice.neighbours.resize(counts.triangles);
    lattice.changed.resize(counts.triangles);
}

// Returns the lattice's triangles of positive area and their neighbours.
SplitLattice open_lattice(const HexMesh2D& mesh, ThreadPool& pool) {
    SplitLattice lattice;
    lattice.points = mesh.positions;
    RawVector<std::int32_t> numbers(step::slot_count(mesh.columns, mesh.rows));
    ThreadTeam::run(pool, [&](const ThreadTeam& team) {
        const unsigned count =
            step::number_slots(team, mesh.columns, mesh.rows, mesh.positions.data(), numbers.data());
        if (team.is_first()) {
            const std::size_t room = count + count / 4;  // splits add a tenth to a quarter
            lattice.triangles.reserve(room);
            lattice.neighbours.reserve(room);
            lattice.changed.reserve(room);
            lattice.points.reserve(room / 2);
            resize(lattice, {static_cast<unsigned>(lattice.points.size()), count});
        }
        team.wait();
        step::write_slots(team, mesh.columns, mesh.rows, numbers.data(), view_of(lattice));
    });
    return lattice;
}

// Splits the edges whose triangles own them at the shares that share_of(splitter, t, k) returns.
template <typename ShareOf>
void split(SplitLattice& lattice, ThreadPool& pool, const ShareOf& share_of) {
    const step::LatticeCounts before{static_cast<unsigned>(lattice.points.size()),
                                     static_cast<unsigned>(lattice.triangles.size())};
    // the parts of a triangle are fewer than four, and most triangles stay whole
    RawVector<std::array<float, 3>> shares(std::size_t{4} * before.triangles);
    RawVector<step::Cut> cuts(before.triangles);
    RawVector<step::LatticeCounts> firsts(before.triangles);
    RawVector<std::uint32_t> list(before.triangles);
    unsigned count = 0;
    const step::SplitArrays arrays{reinterpret_cast<float(*)[3]>(shares.data()), cuts.data(), firsts.data(),
                                   list.data(), &count};
    ThreadTeam::run(pool, [&](const ThreadTeam& team) {
        const Splitter whole(view_of(lattice), arrays);
        whole.clear_shares(team, before.triangles);
        team.each(before.triangles, [&](std::size_t i) {
            const std::int32_t t = static_cast<std::int32_t>(i);
            for (int k = 0; k < 3; ++k)
                if (whole.owns(t, k)) whole.put_share(t, k, share_of(whole, t, k));
        });
        const step::LatticeCounts after = whole.number(team, before);
        if (team.is_first()) resize(lattice, after);
        team.wait();
        Splitter(view_of(lattice), arrays).split(team);
    });
}

}  // namespace

SplitLattice split_at_silhouettes(const PixelSurfaces& surfaces, const HexMesh2D& mesh,
                                  const std::vector<std::uint8_t>& on_silhouette, ThreadPool& pool) {
    SplitLattice lattice = open_lattice(mesh, pool);
    const CrackQuery query{surfaces.view(), surfaces.tiles()};
    split(lattice, pool, [&](const Splitter& splitter, std::int32_t t, int k) {
        const auto [a, b, p, q] = splitter.edge(t, k);
        return surfaces.may_cross(p, q) && surfaces.may_meet(p, q)
                   ? step::open_crossing(query, p, on_silhouette[a], q, on_silhouette[b], true)
                   : -1;
    });
    return lattice;
}

void split_straddling(const PixelSurfaces& surfaces, std::span<const std::uint8_t> straddling,
                      SplitLattice& lattice, ThreadPool& pool) {
    const CrackQuery query{surfaces.view(), surfaces.tiles()};
    split(lattice, pool, [&](const Splitter& splitter, std::int32_t t, int k) {
        const std::int32_t n = lattice.neighbours[t][k];
        if (!straddling[t] && !(n >= 0 && straddling[n])) return -1.0f;
        const auto [a, b, p, q] = splitter.edge(t, k);
        if (!surfaces.may_meet(p, q)) return -1.0f;
        return step::nearer_middle(step::crossing_from_middle(query, p, q, true),
                                   step::crossing_from_middle(query, p, q, false));
    });
}

}  // namespace hexrelief::surface
