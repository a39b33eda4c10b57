#include "pipeline/config/fields.h"

namespace hexrelief::config {

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

}  // namespace hexrelief::config
