#include "pipeline/readers/netpbm_header.h"

#include <algorithm>

#include "pipeline/readers/parse_text.h"

namespace hexrelief::readers::codec {
std::string_view NetpbmHeader::next_word() {
    const auto& bytes = source_.bytes;
    while (at_ < bytes.size() && (is_space(bytes[at_]) || bytes[at_] == '#')) {
        if (bytes[at_] == '#') {
            while (at_ < bytes.size() && bytes[at_] != '\n' && bytes[at_] != '\r') ++at_;
        } else {
            ++at_;
        }
    }
    const std::size_t start = at_;
    while (at_ < bytes.size() && !is_space(bytes[at_]) && bytes[at_] != '#') ++at_;
    return {reinterpret_cast<const char*>(bytes.data()) + start, at_ - start};
}

unsigned NetpbmHeader::next_number(const char* what) {
    const std::string_view word = next_word();
    const bool digits = std::all_of(word.begin(), word.end(), [](char c) { return c >= '0' && c <= '9'; });
    if (word.empty() || word.size() > 9 || !digits) {
        refuse(source_.path, std::string("its header has ") + excerpt(word) + " as " + what +
                                 " instead of a whole number; export it again");
    }
    unsigned value = 0;
    for (char c : word) value = value * 10 + static_cast<unsigned>(c - '0');
    return value;
}

std::size_t NetpbmHeader::samples_at(unsigned long long sample_bytes, unsigned long long file_bytes) const {
    const auto& bytes = source_.bytes;
    if (at_ >= bytes.size() || !is_space(bytes[at_])) {
        refuse(source_.path, "its header ends without white space before the samples; export it again");
    }
    const unsigned long long left = file_bytes - at_ - 1;
    if (left < sample_bytes) {
        refuse(source_.path, "truncated: the header promises " + std::to_string(sample_bytes) +
                                 " bytes of samples, " + std::to_string(left) +
                                 " are there; copy or export it again");
    }
    const bool windows =
        bytes[at_] == '\r' && left == sample_bytes + 1 && at_ + 1 < bytes.size() && bytes[at_ + 1] == '\n';
    return at_ + (windows ? 2 : 1);
}

}  // namespace hexrelief::readers::codec
