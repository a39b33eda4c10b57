#include "pipeline/batch/pair_rules.h"

namespace hexrelief::batch {

std::string PairRule::files() const {
    return left + (*right ? std::string(" and ") + right : "");
}

std::span<const PairRule> pair_rules() {
    static const std::vector<PairRule> rules = {
        {"side by side", "{name}sbs.*", "", {"{name}calib.*"}, true, "sbs"},
        {"side by side, in words", "{name}side-by-side.*", "", {"{name}calib.*"}, true, "sbs"},
        {"left and right in one", "{name}left-right.*", "", {"{name}calib.*"}, true, "sbs"},
        {"left over right", "{name}over-under.*", "", {"{name}calib.*"}, true, "tb"},
        {"left and right", "left.*", "right.*", {"calib.*"}},
        {"Middlebury 2003", "im2.*", "im6.*", {"calib.*"}, false},
        {"Middlebury 2006", "view1.*", "view5.*", {"calib.*"}, false},
        {"Middlebury 2014", "im0.*", "im1.*", {"calib.*"}},
        {"KITTI",
         "image_2/{name}.*",
         "image_3/{name}.*",
         {"calib/{name}.*", "calib/{frame}.*", "calib_cam_to_cam/{frame}.*", "calib.*"}},
        {"KITTI 2012", "colored_0/{name}.*", "colored_1/{name}.*", {"calib/{frame}.*"}},
        {"KITTI, grey", "image_0/{name}.*", "image_1/{name}.*", {"calib/{frame}.*", "calib.*"}},
        {"KITTI raw",
         "image_02/data/{name}.*",
         "image_03/data/{name}.*",
         {"calib_cam_to_cam.*", "../calib_cam_to_cam.*"}},
        {"EuRoC", "cam0/data/{name}.*", "cam1/data/{name}.*", {"cam0/sensor.*"}},
        {"folders cam0 and cam1", "cam0/{name}.*", "cam1/{name}.*", {"calib.*"}},
        {"left- and right- in folders", "left/left{name}.*", "right/right{name}.*", {"calib.*"}},
        {"-left and -right in folders", "left/{name}left.*", "right/{name}right.*", {"calib.*"}},
        {"folders left and right", "left/{name}.*", "right/{name}.*", {"calib/{name}.*", "calib.*"}},
        {"-left and -right", "{name}left.*", "{name}right.*", {"{name}calib.*", "calib.*"}},
        {"left- and right-", "left{name}.*", "right{name}.*", {"calib{name}.*", "calib.*"}, false},
        {"-L and -R", "{name}L.*", "{name}R.*", {"{name}calib.*", "calib.*"}, false},
        {"L- and R-", "L{name}.*", "R{name}.*", {"calib.*"}, false},
        {"JPS", "{name}.jps", "", {"{name}_calib.*", "calib.*"}},
        {"PNS", "{name}.pns", "", {"{name}_calib.*", "calib.*"}},
        {"MPO", "{name}.mpo", "", {"{name}_calib.*", "calib.*"}},
        {"spatial photograph", "{name}.heic", "", {"{name}_calib.*"}, true, "", "ster"},
    };
    return rules;
}

std::span<const SideWords> side_words() {
    static constexpr SideWords words[] = {{"left", "right"},      {"im0", "im1"},
                                          {"im2", "im6"},         {"view1", "view5"},
                                          {"image_2", "image_3"}, {"colored_0", "colored_1"},
                                          {"image_0", "image_1"}, {"image_02", "image_03"},
                                          {"cam0", "cam1"},       {"_L", "_R"}};
    return words;
}

}  // namespace hexrelief::batch
