// How a long stage tells how far it is.
#pragma once

#include <functional>

namespace hexrelief {

// Called now and then with the share done, 0..1; may throw to stop.
using ProgressFunction = std::function<void(double)>;

}  // namespace hexrelief
