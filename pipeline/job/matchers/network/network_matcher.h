// Matches rectified pairs by a network: prepares the pictures as it wants them, and reads its maps.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "pipeline/data/disparity_map.h"
#include "pipeline/job/matchers/network/model_file.h"
#include "pipeline/job/matchers/network/network.h"

namespace hexrelief::job {

struct NetworkAnswer {
    DisparityMap map;  // of the left view, in px of the pair, with the network's sign
    std::vector<float>
        confidence;  // 0 .. 1 for each pixel, by its maps of confidence and occlusion; may be empty
    std::vector<std::string> told;  // what was done to the pictures
};

// A part of a picture's side that the network sees, and the part of it whose answer is kept.
struct NetworkWindow {
    int first, kept_first, kept_end;
};

// Returns windows of `side` px over `length` px. Their kept parts lie one beside the other, `before` and
// `after` px away from the window's ends except at the picture's; none if a window would keep less than a
// quarter.
std::vector<NetworkWindow> windows_of(int length, int side, int before, int after);

// Return the operator that OpenCV's or ONNX Runtime's words name, empty = none, and the words that say why,
// without places in the library's code.
std::string operator_in(const std::string& words);
std::string reason_in(const std::string& words);

class NetworkMatcher {
  public:
    // kind: a row of config/models.yaml; empty = by the file. Throws Error(input) for a file that is no
    // network of two pictures, Error(usage) for a kind that is none.
    NetworkMatcher(std::filesystem::path file, const std::string& kind, int threads);

    // ndisp: disparities to be expected, from 0 on. Pictures are padded to the network's multiple. One that
    // fixes its size gets tiles, or where the disparities do not fit into a tile the pair made smaller.
    // Throws Error(input) if the network cannot be run, or answers no map.
    NetworkAnswer match(const StereoPair& pair, int ndisp);

  private:
    struct Size {
        int width, height;
    };
    struct Maps;

    void find_pictures();
    void find_outputs();
    Size size_for(int width, int height) const;
    NetworkAnswer match_in_windows(const StereoPair& pair, int ndisp, Size size);
    NetworkAnswer match_smaller(const StereoPair& pair, int ndisp, Size size);
    Maps run(const StereoPair& pair, int x, int y, Size size);
    std::vector<Tensor> run_network(const std::vector<Tensor>& inputs, Size size);
    [[noreturn]] void refuse(const std::string& what) const;

    std::filesystem::path file_;
    ModelFile model_;
    ModelKind kind_;
    int threads_;
    int channels_ = 3;        // of a picture
    bool is_joined_ = false;  // true if one input takes both pictures' channels
    bool is_right_first_ = false;
    std::vector<std::size_t> disparity_;  // outputs that may be the disparities
    std::ptrdiff_t occlusion_ = -1, confidence_ = -1;
    std::unique_ptr<Network> network_;
    Size loaded_{0, 0};
};

}  // namespace hexrelief::job
