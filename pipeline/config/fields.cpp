#include "pipeline/config/fields.h"

#include <algorithm>

#include "pipeline/config/field_makers.h"

namespace hexrelief::config {
namespace {

std::vector<Field> disparity_fields() {
    return {
        choice(KEY(disparity.method), {"sgm", "sgbm", "command", "onnx"},
               "sgm: semi-global matching on census and colour, on the CPU and on CUDA; sgbm: OpenCV's "
               "StereoSGBM; command: a program of your own, by disparity.command or disparity.worker; onnx: "
               "a network, disparity.model"),
        text(KEY(disparity.command),
             "command: the words of a program that is run for each view, without a shell: {left} and {right} "
             "are the rectified pictures as PNG, {out} the map to write, in px of the left view, as PFM; "
             "{out.npy}, {out.tiff}, ... = in another format that --disparity reads; {ndisp} = disparities "
             "to expect; {confidence} a map of 0 to 1 that may be written as well"),
        text(KEY(disparity.worker),
             "command: the words of a program that matches pair after pair: it reads lines of JSON, "
             "{\"left\": FILE, \"right\": FILE, \"out\": FILE, \"confidence\": FILE, \"ndisp\": N}, and "
             "answers each with the line {\"ok\": true} or {\"error\": TEXT}"),
        number(KEY(disparity.timeout_s), "s", stages::DisparityConfig::kTimeout_s,
               "command, onnx: longest wait for a view's map"),
        file(KEY(disparity.model), "onnx: the network's ONNX file; in a file relative to it; empty = none"),
        text(KEY(disparity.model_kind),
             "onnx: the row of config/models.yaml that says how the network takes its pictures; empty = by "
             "the file's SHA-256 or name"),
        number(KEY(disparity.least_confidence), "", stages::DisparityConfig::kConfidence,
               "command, onnx: pixels of lower confidence are unknown, if confidences are given"),
        number(
            KEY(disparity.working_px), "px", stages::DisparityConfig::kWorkingSize_px,
            "longest side at which a pair is matched and meshed; a larger pair is reduced by the least whole "
            "number that makes it so, its texture is not; soft photographs that are aligned by their points, "
            "or lie partly behind infinity, are halved further as long as 900 px remain; 0 = never. Keys in "
            "px from here on are of the reduced pair, unless they say that they are of the full one"),
        number(KEY(disparity.min_disparity_px), "px", stages::DisparityConfig::kMinDisparity_px,
               "least disparity searched, px of the full pair"),
        number(KEY(disparity.num_disparities_px), "px", stages::DisparityConfig::kNumDisparities_px,
               "number of disparities searched, px of the full pair, rounded up to a multiple of 16, at most "
               "the width; 0 = the calibration's ndisp, else chosen from the pair"),
        number(KEY(disparity.p1), "", stages::DisparityConfig::kPenalty,
               "penalty for a disparity step of 1; 0 = 45, sgbm: 16 * channels * block_size^2"),
        number(KEY(disparity.p2), "", stages::DisparityConfig::kPenalty,
               "penalty for a larger step; 0 = 330, sgbm: 64 * channels * block_size^2"),
        number(KEY(disparity.speckle_window_px), "px", stages::DisparityConfig::kSpeckleWindow_px,
               "largest area of a speckle to remove; 0 = off"),
        number(KEY(disparity.speckle_range_px), "px", stages::DisparityConfig::kSpeckleRange_px,
               "disparity step that ends a speckle"),
        optional(KEY(disparity.farthest_px), "px", {-16384, 16384},
                 "matches of a smaller disparity, px of the full pair, are removed in speckles of four times "
                 "the area; null = by the match of the pair made small, which tells how far the scene goes"),
        optional(KEY(disparity.left_right_check_px), "px", {-1, 1000},
                 "largest allowed difference between the two views' disparities; below 0 = off; null = "
                 "0.5625, sgbm: 1"),
        choice(KEY(disparity.fill), {"none", "planes"},
               "pixels without a match, and those that a supplied map does not know but its picture shows: "
               "none = unknown; planes = on the planes around them"),
        choice(KEY(disparity.dequantize), {"auto", "none"},
               "a supplied map of whole pixels or other steps of 0.1 to 1 px: auto = the smoothest surface "
               "within half a step is meshed, unless budget.max_error_px asks for less than a step; a pair's "
               "noisy matches: auto = the smoothest surface within the noise; none = as they are"),
        flag(KEY(disparity.color),
             "sgbm: match all channels of colour pairs; grey is faster and, measured, better"),
        number(KEY(disparity.block_size_px), "px", stages::DisparityConfig::kBlockSize_px,
               "sgbm: side of the matched block, odd"),
        number(KEY(disparity.pre_filter_cap), "", stages::DisparityConfig::kPreFilterCap,
               "sgbm: clipping of the prefiltered images' x derivative"),
        number(KEY(disparity.uniqueness_ratio_percent), "%",
               stages::DisparityConfig::kUniquenessRatio_percent,
               "sgbm: margin by which the best match must win"),
        choice(KEY(disparity.mode), {"sgbm", "hh", "sgbm_3way", "hh4"},
               "sgbm: directions of StereoSGBM: 5, 8, 3, 4"),
    };
}

std::vector<Field> density_fields() {
    return {
        number(KEY(density.exponent), "", stages::DensityConfig::kExponent,
               "density = (disparity / scale)^exponent, at most 1"),
        number(KEY(density.scale_percentile), "%", stages::DensityConfig::kScalePercentile,
               "the scale is this percentile of the known disparities, which a few wrong pixels do not move; "
               "100 = the largest"),
        choice("density.background.method", MEMBER(density.background_method),
               {"auto", "none", "fraction", "threshold_px", "otsu"},
               "how the background is told apart; auto = as by fraction, but only where depth "
               "discontinuities part it from the rest and this is a tenth of the map, else none"),
        number("density.background.fraction", MEMBER(density.background_fraction), "",
               stages::DensityConfig::kBackgroundFraction,
               "auto, fraction: below this share of the scale is background"),
        number("density.background.threshold_px", MEMBER(density.background_threshold_px), "px",
               stages::DensityConfig::kBackgroundThreshold_px,
               "threshold_px: below this disparity, px of the full pair, is background"),
        number(KEY(density.floor), "", stages::DensityConfig::kFloor,
               "least density of a known pixel, share of the largest"),
        number(KEY(density.detail), "", stages::DensityConfig::kDetail,
               "share of the mesh that goes where the surface is curved or steps at a depth discontinuity; 0 "
               "= the paper's density alone"),
    };
}

std::vector<Field> mesh_fields() {
    return {
        number(KEY(mesh.spacing_px), "px", {2, 256}, "g: the lattice has W/g x H/g vertices"),
        choice(KEY(mesh.method), {"cellular", "sequential"},
               "cellular = the parallel model; sequential = the paper's CPU counterpart (Eq. 5), slow"),
        number(KEY(mesh.levels), "", {0, 12},
               "lattice levels, coarse to fine; 1 = the paper's single level, 0 = chosen from the size"),
        number(KEY(mesh.t_max), "", {1, 1e6},
               "iterations of each level; 60 serve better where no balance follows"),
        number(KEY(mesh.alpha_init), "", {0, 1}, "learning rate at the first iteration of all (Eq. 3)"),
        number(KEY(mesh.alpha_final), "", {0, 1}, "learning rate after the last"),
        number(KEY(mesh.sigma_init), "", {0.01, 1000},
               "neighbourhood radius in lattice steps at the first iteration of all (Eq. 4)"),
        number(KEY(mesh.sigma_level_init), "", {0.01, 1000},
               "neighbourhood radius at the first iteration of each finer level"),
        number(KEY(mesh.sigma_level_final), "", {0.01, 1000},
               "neighbourhood radius after the last of each level but the finest"),
        number(KEY(mesh.sigma_final), "", {0.01, 1000},
               "neighbourhood radius after the last iteration of all"),
        number(KEY(mesh.co), "px", {2, 4096}, "side of a cell of the cellular matrix"),
        number(KEY(mesh.delta), "", {0, 64},
               "points that the densest cell draws in an iteration (Eq. 6; the paper's 1)"),
        number(KEY(mesh.ssr), "", {0, 4096}, "spiral search range in cells; 0 = unlimited, exact with crr 1"),
        number(KEY(mesh.crr), "", {1, 1e6},
               "cell refresh rate: iterations between two sortings of the lattice's vertices into cells"),
        number(KEY(mesh.prr), "", {1, 20},
               "position refresh rate: iterations that seek their best matching units on the same positions; "
               "1 = always the newest"),
        number(KEY(mesh.prr_final), "", {0, 256},
               "prr at the last iteration of all; 0 = mesh.prr; never more than 20, nor beyond the next cell "
               "refresh"),
        number(KEY(mesh.magnification), "", {0.1, 4},
               "points are drawn from density^magnification; 1 = the paper's; 1.3 serves better where no "
               "balance follows"),
        choice(KEY(mesh.border), {"fit", "slide", "free"},
               "fit = the lattice's border stays on that of the smallest rectangle around all density, top "
               "and bottom bent into empty valleys; slide = on the image's; free = the paper's: it moves "
               "like the rest"),
        number(KEY(mesh.seed), "", {0, kMaxSeed}, "seed of all random draws", {"--seed", "N"}),
    };
}

std::vector<Field> balance_fields() {
    return {
        flag(KEY(mesh.balance.enabled),
             "balance each level of the cellular method after its training; false = the map alone"),
        number(
            KEY(mesh.balance.iterations), "", {1, 300},
            "Newton iterations on the finest level and the next, twice as many on coarser ones; up to eight "
            "times as many while a level is more than 3 % from balance, fewer where it gets there earlier"),
        number(KEY(mesh.balance.sweeps), "", {2, 100}, "sweeps of the linear solver in each iteration"),
        number(KEY(mesh.balance.least_angle_deg), "deg", {1, 30},
               "balance against shape: 1 % of the triangles may be thinner; smaller = better balance, larger "
               "= better shape"),
        number(KEY(mesh.balance.floor), "", {0.0001, 0.5},
               "density of empty pixels while balancing, share of the others' mean"),
    };
}

std::vector<Field> surface_fields() {
    return {
        choice(KEY(surface.discontinuities), {"cut", "bridge"},
               "cut = cut along depth discontinuities; bridge = open only at background and unknown regions"),
        number(KEY(surface.least_discontinuity_px), "px", {0, 65536},
               "neighbours that differ by more are on two surfaces; 0 = 1 px"),
        number(
            KEY(surface.split_rounds), "", {1, 8},
            "how often straddling triangles are split and silhouettes fitted anew; more = truer, but slower"),
        number(
            KEY(surface.silhouette_inset_px), "px", {0, 0.5},
            "how far inside of its own surface each silhouette ends at a depth discontinuity above 2.3 px"),
        number(KEY(surface.silhouette_rounds), "", {0, 8},
               "how often silhouettes are moved, by at most 0.75 px, where pixels beside them are wrong or "
               "uncovered; one round takes longer than the rest of this stage; 0 = not at all"),
        number(KEY(surface.min_component), "", {0, 1e9},
               "components of fewer triangles are dropped; 0 = keep all"),
        number(KEY(surface.farthest), "", {0, 1e6},
               "a pair's mesh ends at so many times the depth that its matches support, what seems farther "
               "lies on a backdrop there; 0 = anywhere"),
        choice(KEY(surface.views), {"both", "left"},
               "cameras whose views the mesh is made of: both = with what only the right one sees, of pairs "
               "and of maps with --disparity-right"),
        number(KEY(surface.behind), "baselines", {0, 8},
               "with views=both, also of one map: behind silhouettes the farther surface continues, as far "
               "as cameras so many baselines beyond both see; 0 = not at all; if not given, a pair has as "
               "many as a turn by 20 degrees, of photographs without a calibration by 30, takes, 1 to 8"),
    };
}

std::vector<Field> run_fields() {
    return {
        number(KEY(budget.vertices), "", {0, kAny},
               "the finest mesh of at most so many vertices, made as by the preset compact if no "
               "configuration is named; 0 = none given",
               {"--vertices", "N"}),
        number(KEY(budget.max_bytes), "byte", {0, 1e15},
               "the best mesh and texture of at most so many bytes in each output, with the files beside it; "
               "made likewise; 0 = none given",
               {"--max-bytes", "N"}),
        number(KEY(budget.max_error_px), "px", {0, 100},
               "the coarsest mesh whose error in both cameras' views is at most this; near surfaces are "
               "weighted more, and borders have half a pixel of slack; 0 = none given",
               {"--max-error-px", "PX"}),
        number("limits.max_pixels", MEMBER(limits.reading.max_pixels), "px",
               {1, static_cast<double>(readers::kMaxPixels)},
               "pictures, maps and masks of more are refused by their header"),
        number(KEY(limits.max_memory), "byte", {0, 1e15},
               "a run that is estimated to take more, by its input's header, is refused; 0 = none is"),
        choice(KEY(run.backend), {"auto", "cpu", "cuda"},
               "auto = a GPU if it pays, else the CPU; it pays if what it could do would take the CPU longer "
               "than 0.2 s, which a GPU takes to start: pairs from about a megapixel on",
               {"--backend"}),
        number(KEY(run.threads), "", {0, 1024}, "CPU threads, 0 = all that the process may use",
               {"--threads", "N"}),
        flag(KEY(run.strict),
             "an input that looks wrong (views swapped, rows that differ, depths in place of disparities, "
             "...) ends the run instead of being warned of",
             {"--strict"}),
    };
}

}  // namespace

int edit_distance(const std::string& a, const std::string& b) {
    std::vector<std::vector<int>> d(a.size() + 1, std::vector<int>(b.size() + 1));
    for (std::size_t i = 0; i <= a.size(); ++i)
        for (std::size_t j = 0; j <= b.size(); ++j) {
            if (i == 0 || j == 0) {
                d[i][j] = static_cast<int>(i + j);
                continue;
            }
            d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] != b[j - 1])});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
        }
    return d[a.size()][b.size()];
}

std::string nearest_name(const std::string& name, const std::vector<std::string>& candidates) {
    if (name.empty() || name.size() > 100) return {};
    std::string best;
    int best_distance = std::max(2, static_cast<int>(name.size()) / 3) + 1;
    for (const std::string& candidate : candidates) {
        int distance = edit_distance(name, candidate);
        // A name without its unit, "spacing" for "spacing_px", counts as one wrong letter.
        if (candidate.size() > name.size() && candidate.compare(0, name.size() + 1, name + "_") == 0)
            distance = 1;
        if (distance < best_distance) {
            best_distance = distance;
            best = candidate;
        }
    }
    return best;
}

const std::vector<Section>& config_sections() {
    static const std::vector<Section> sections = {
        {"input", "How supplied files are read"},
        {"input.disparity", "A supplied disparity map: disparity = sample / scale + offset_px",
         "--disparity"},
        {"input.depth", "A supplied depth map", "--depth"},
        {"input.mask", "A supplied mask: what is 0 is unknown; and the picture's own"},
        {"input.confidence", "Supplied confidences of a disparity or depth map"},
        {"input.calibration",
         "The rectified camera; given values override the file's, nothing given = relative units"},
        {"input.stereo", "A file that holds both pictures of a pair", "--stereo"},
        {"disparity", "Stage 1, pair -> disparities: semi-global matching"},
        {"density", "Stage 2, disparities -> density that attracts the mesh (paper, section 3)"},
        {"density.background", "What belongs to the background and gets no mesh"},
        {"mesh", "Stage 3, density -> 2D mesh: the cellular self-organizing map (paper, section 4, Table 1)"},
        {"mesh.balance", "After the training: the same density in all honeycomb cells (Eq. 1 and 2)"},
        {"surface", "Stage 4, 2D mesh -> surface in space"},
        {"export", "Stage 5, surface -> files"},
        {"export.draco", "For compression: draco, and .drc"},
        {"budget",
         "At most one limit instead of a spacing: mesh.spacing_px is then searched for, from its value on"},
        {"limits", "What is refused before any work, as too large for whoever runs it"},
        {"run", "How the job is run; changes no byte of the meshes"},
    };
    return sections;
}

const Field* find_field(const std::string& path) {
    for (const Field& field : config_fields())
        if (field.path == path) return &field;
    return nullptr;
}

const Section* find_section(const std::string& path) {
    for (const Section& section : config_sections())
        if (section.path == path) return &section;
    return nullptr;
}

std::string section_of(const std::string& path) {
    const std::size_t dot = path.rfind('.');
    return dot == std::string::npos ? "" : path.substr(0, dot);
}

const std::vector<Field>& config_fields() {
    static const std::vector<Field> table = [] {
        std::vector<Field> fields = input_fields();
        append(fields, disparity_fields());
        append(fields, density_fields());
        append(fields, mesh_fields());
        append(fields, balance_fields());
        append(fields, surface_fields());
        append(fields, export_fields());
        append(fields, run_fields());
        return fields;
    }();
    return table;
}

}  // namespace hexrelief::config
