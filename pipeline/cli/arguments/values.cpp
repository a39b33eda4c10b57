#include "pipeline/cli/arguments/values.h"

#include <cmath>
#include <cstdio>

#include "pipeline/data/error.h"

namespace hexrelief::cli {

Shard parse_shard(const std::string& text) {
    Shard shard;
    if (text.empty()) return shard;
    int end = 0;
    // NOLINTNEXTLINE(cert-err34-c): six digits are no overflow
    if (std::sscanf(text.c_str(), "%6zu/%6zu%n", &shard.number, &shard.of, &end) != 2 ||
        static_cast<std::size_t>(end) != text.size() || shard.number < 1 || shard.number > shard.of)
        throw Error(ErrorKind::usage, "--shard: must be K/N with K from 1 to N, not '" + text + "'");
    return shard;
}

std::uint64_t parse_memory(const std::string& text) {
    if (text.empty()) return 0;
    double value = 0;
    char unit = 'B', rest = 0;
    // NOLINTNEXTLINE(cert-err34-c): twenty digits are no overflow
    const int read = std::sscanf(text.c_str(), "%20lf%c%c", &value, &unit, &rest);
    static const std::string kUnits = "BKMGT";
    const std::size_t power = kUnits.find(unit);
    const bool is_size = (read == 1 || read == 2) && power != std::string::npos;
    const double bytes = is_size ? std::ldexp(value, static_cast<int>(10 * power)) : 0;
    if (!(bytes >= 1 && bytes < 1e18))
        throw Error(ErrorKind::usage, "--memory: must be like 8G or 512M, not '" + text + "'");
    return static_cast<std::uint64_t>(bytes);
}

}  // namespace hexrelief::cli
