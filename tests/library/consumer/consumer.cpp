// consumer FOLDER OUT.glb: the sample pair's disparities and picture to a mesh; with a third argument from
// files to files.
#include <hexrelief/run.h>

#include <cstdio>

int main(int argc, char** argv) try {
    const std::string folder = argc > 1 ? argv[1] : "samples";
    const hexrelief::Disparities disparity = hexrelief::read_disparities(folder + "/disparity.pfm");
    const hexrelief::Picture left = hexrelief::read_picture(folder + "/left.png");
    const hexrelief::Camera camera{.file = folder + "/calib.txt"};
    hexrelief::Options options{
        .settings = {{"mesh.spacing_px", "8"}, {"density.background.fraction", "0.1"}}};
    if (argc > 3) {
        hexrelief::FileRequest files{.disparity = folder + "/disparity.pfm", .color = folder + "/left.png"};
        files.outputs = {argv[2]};
        options.direct = {{"--calib", camera.file}};
        return hexrelief::run(files, options).triangles > 0 ? 0 : 1;
    }
    const hexrelief::Mesh mesh = hexrelief::mesh(disparity.view(), left.view(), camera, options);
    mesh.save(argc > 2 ? argv[2] : "relief.glb");
    std::printf("%zu vertices, %zu triangles\n", mesh.vertex_count(), mesh.face_count());
} catch (const hexrelief::Error& error) {
    std::fprintf(stderr, "consumer: %s\n", error.what());
    return static_cast<int>(error.kind());
}
