// `hexrelief bench batch --files`: the number of rows per second of `hexrelief batch`, from files to files.
#pragma once

#include <iosfwd>

#include "pipeline/bench/batch/bench_batch.h"

namespace hexrelief::bench {

// Runs each scene options.jobs times, each time to a GLB and a report of its own: first one after the other
// on one thread, then options.workers at a time on one thread each; both are done twice, and the better one
// counts. options.threads only counts if options.workers is 0. Writes a row for each scene to `out` as it is
// measured. Throws what run_bench_batch() throws. Call it before any thread is started.
void run_bench_batch_files(const BatchOptions& options, std::ostream& out);

}  // namespace hexrelief::bench
