#include "pipeline/readers/packed_map.h"

#include <bit>

#include "pipeline/readers/source.h"

namespace hexrelief::readers {
namespace {

// A number is the sum of the channels' products with these weights.
struct Weights {
    const char* told;
    double red, green, blue;
    double unknown = codec::kNoData;  // of the numbers
};

constexpr double kCarla_m = 1000.0 / 16777215;  // 24 bits

constexpr Weights kWeights[] = {{},
                                {"CARLA's 24 bits", kCarla_m, 256 * kCarla_m, 65536 * kCarla_m, 1000},
                                {"Sintel's packed disparities", 4, 1.0 / 64, 1.0 / 16384, 0},
                                {"TartanAir's packed floats", 0, 0, 0}};

}  // namespace

const std::vector<std::string>& packing_names() {
    static const std::vector<std::string> names = {"none", "carla", "sintel", "tartanair"};
    return names;
}

namespace codec {

void unpack(Raster& raster, Packing packing, const std::filesystem::path& path) {
    if (packing == Packing::none) return;
    const auto* const bytes = std::get_if<std::vector<std::uint8_t>>(&raster.samples);
    if (bytes == nullptr || raster.channels != 3)
        refuse(path, "it has no red, green and blue of 8 bits to unpack; leave --packed out");
    const bool are_floats = packing == Packing::tartanair;
    if (are_floats == raster.alpha.empty())
        refuse(path,
               are_floats
                   ? "its fourth channel holds nothing, as in no file of TartanAir's; see --packed"
                   : "its fourth channel holds a part of the numbers; --packed tartanair reads those of "
                     "TartanAir");
    const Weights& weights = kWeights[static_cast<std::size_t>(packing)];
    std::vector<float> numbers(bytes->size() / 3);
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        const std::uint32_t red = (*bytes)[3 * i], green = (*bytes)[3 * i + 1], blue = (*bytes)[3 * i + 2];
        numbers[i] =
            are_floats
                ? std::bit_cast<float>(std::uint32_t{raster.alpha[i]} << 24 | red << 16 | green << 8 | blue)
                : static_cast<float>(weights.red * red + weights.green * green + weights.blue * blue);
    }
    raster.samples = std::move(numbers);
    raster.channels = 1;
    raster.alpha.clear();
    raster.nodata = weights.unknown;
    raster.stated.told = weights.told;
}

}  // namespace codec
}  // namespace hexrelief::readers
