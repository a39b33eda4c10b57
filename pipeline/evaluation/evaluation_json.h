// A map's errors as JSON, for `hexrelief evaluate --json` and for Python.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "pipeline/evaluation/evaluate.h"

namespace hexrelief::evaluation {

// Returns all figures by their names, with their units; numbers are not rounded.
nlohmann::ordered_json evaluation_json(const DisparityEvaluation& evaluation);

}  // namespace hexrelief::evaluation
