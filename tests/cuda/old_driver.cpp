// A stand-in for NVIDIA's libcuda.so.1 of CUDA 11.4, as far as the runtime asks it before it gives up.
extern "C" {
int cuInit(unsigned) {
    return 0;
}
int cuDriverGetVersion(int* version) {
    *version = 11040;
    return 0;
}
}
