// A stand-in for NVIDIA's libcuda.so.1 of CUDA 11.4, with the functions that the runtime calls
// before it gives up.
extern "C" {
int cuInit(unsigned) {
    return 0;
}
int cuDriverGetVersion(int* version) {
    *version = 11040;
    return 0;
}
}
