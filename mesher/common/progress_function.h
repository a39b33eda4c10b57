// The callback by which a long stage reports its progress.
#pragma once

#include <functional>

namespace hexrelief {

// Called now and then with the share done, 0..1; may throw to stop the stage.
using ProgressFunction = std::function<void(double)>;

}  // namespace hexrelief
