// Distances of the plain-loop self-organizing maps: on the lattice by walking, in the image by comparing all.
#pragma once

#include <vector>

#include "tests/mesher/naive_levels.h"

namespace hexrelief::testing_mesher {

// Steps between all pairs of vertices.
std::vector<std::vector<int>> lattice_distances(const Level& level);

// The cellular matrix with the cell of each neuron at the last refresh.
class NaiveCells {
  public:
    NaiveCells(const Level& level, int co);
    int columns() const { return columns_; }
    int count() const { return columns_ * rows_; }
    int cell_at(float x, float y) const;
    void refresh(const Level& level);
    // The rings of cells (of the last refresh) around the point's own are opened one by one, at most ssr of
    // them or all where it is 0, in each the cells that the circle through the best of the rings before
    // reaches. -1 where none holds a neuron.
    int nearest(const Level& level, int ssr, float px, float py) const;

  private:
    int co_, columns_, rows_;
    std::vector<int> listed_;
};

// The nearest of all neurons; of equals the lowest index.
int nearest_of_all(const Level& level, float px, float py);

}  // namespace hexrelief::testing_mesher
