// The ranges of the field table against those that the stages check.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "pipeline/config/fields.h"
#include "pipeline/data/error.h"
#include "pipeline/readers/disparity_reader.h"

namespace hexrelief::config {
namespace {

// Numbers whose stage takes any: a limit beyond what is searched, a sample.
const std::set<std::string> kUnchecked = {"disparity.farthest_px", "disparity.left_right_check_px",
                                          "input.disparity.unknown"};

bool is_checked_by_its_stage(const Field& field) {
    const std::string section = section_of(field.path);
    const bool is_number = field.type == FieldType::integer || field.type == FieldType::real;
    return is_number && !kUnchecked.contains(field.path) &&
           (section == "disparity" || section.starts_with("density") || section == "input.disparity");
}

FieldValue value_of(const Field& field, double number) {
    return field.type == FieldType::integer ? FieldValue(static_cast<long long>(number)) : FieldValue(number);
}

// The nearest number of the field's type towards `to`.
double beside(const Field& field, double number, double to) {
    return field.type == FieldType::integer ? number + (to < number ? -1 : 1) : std::nextafter(number, to);
}

// As the stages themselves judge it: the table's own check is passed by.
bool stages_take(const Field& field, double number) {
    Config config;
    field.set(config, value_of(field, number));
    try {
        const Image wide{2 * stages::kLargestRange_px, 1, 1, {}};
        stages::check_matchable({wide, wide}, config.disparity);
        const DisparityMap map{8, 8, std::vector<float>(64, 5.0F)};
        stages::compute_density(map, config.density);
        readers::codec::Raster raster;
        raster.width = 1, raster.height = 1;
        raster.samples = std::vector<float>{5};
        config.input.disparity.beyond_px = -1e9;  // a scale or an offset below 0 gives such disparities
        readers::disparities_of(raster, "map", config.input.disparity);
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::usage) << error.what();
        EXPECT_NE(std::string(error.what()).find(field.path), std::string::npos) << error.what();
        return false;
    }
    return true;
}

bool table_takes(const Field& field, double number) {
    Config config;
    return assign_value(config, field, value_of(field, number)).empty();
}

TEST(Ranges, OfTheTableAreThoseOfTheStages) {
    constexpr double kInf = std::numeric_limits<double>::infinity();
    int fields = 0;
    for (const Field& field : config_fields()) {
        if (!is_checked_by_its_stage(field)) continue;
        ++fields;
        const auto& [min, max] = field.range;
        for (const double inside : {min, max}) {
            EXPECT_TRUE(table_takes(field, inside)) << field.path << " " << inside;
            EXPECT_TRUE(stages_take(field, inside)) << field.path << " " << inside;
        }
        for (const double outside : {beside(field, min, -kInf), beside(field, max, kInf)}) {
            EXPECT_FALSE(table_takes(field, outside)) << field.path << " " << outside;
            EXPECT_FALSE(stages_take(field, outside)) << field.path << " " << outside;
        }
    }
    EXPECT_GE(fields, 17);
}

TEST(Ranges, WhatTheMatcherCannotSearchIsRefusedByTheTable) {
    EXPECT_FALSE(table_takes(*find_field("disparity.num_disparities_px"), stages::kLargestRange_px + 1));
    EXPECT_FALSE(table_takes(*find_field("disparity.min_disparity_px"), -stages::kLargestRange_px));
}

}  // namespace
}  // namespace hexrelief::config
