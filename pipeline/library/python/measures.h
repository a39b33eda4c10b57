// Figures of maps and of surfaces against a true map, for Python.
#pragma once

#include <pybind11/pybind11.h>

namespace hexrelief::library {

// Adds evaluate() and measure_surface(), which return JSON, to the module.
void add_measures(pybind11::module_& module);

}  // namespace hexrelief::library
