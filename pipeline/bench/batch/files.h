// `hexrelief bench batch --files`: rows a second as `hexrelief batch` does them, from files to files.
#pragma once

#include <iosfwd>

#include "pipeline/bench/batch/bench_batch.h"

namespace hexrelief::bench {

// Each scene as often as options.jobs says, each time to a GLB and a report of its own: one after the other
// on one thread, then options.workers at a time on one thread each, and both once more; the best of the two
// counts. Threads are not taken from the options. Writes a row for each scene to `out` as they come. Throws
// as run_bench_batch(). Call it before any thread is started.
void run_bench_batch_files(const BatchOptions& options, std::ostream& out);

}  // namespace hexrelief::bench
