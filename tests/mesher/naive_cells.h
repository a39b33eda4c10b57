// Distances for the plain-loop self-organizing maps: on the lattice by walking, in the
// image by comparing all.
#pragma once

#include <vector>

#include "tests/mesher/naive_levels.h"

namespace hexrelief::testing_mesher {

// Returns the number of steps between each two vertices.
std::vector<std::vector<int>> lattice_distances(const Level& level);

// The cellular matrix with each neuron's cell at the last refresh.
class NaiveCells {
  public:
    NaiveCells(const Level& level, int co);
    int columns() const { return columns_; }
    int count() const { return columns_ * rows_; }
    int cell_at(float x, float y) const;
    void refresh(const Level& level);
    // Opens the rings of cells (of the last refresh) around the point's own cell one by one, at most ssr
    // rings or all if ssr is 0; in each ring it searches the cells that the circle through the nearest neuron
    // of the preceding rings reaches. Returns the nearest neuron found, or -1.
    int nearest(const Level& level, int ssr, float px, float py) const;

  private:
    int co_, columns_, rows_;
    std::vector<int> listed_;
};

// Returns the nearest of all neurons, of equally near ones the lowest index.
int nearest_of_all(const Level& level, float px, float py);

}  // namespace hexrelief::testing_mesher
