/* CUDA's words for a processor without it: blocks one after the other, the threads of a block as threads. */
#include <barrier>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <thread>
#include <vector>

#define __device__
#define __global__
#define __shared__ static
#define __forceinline__ inline

struct place { unsigned x; };
static thread_local place threadIdx, blockIdx, blockDim;
static std::barrier<> *together;
static void __syncthreads() { together->arrive_and_wait(); }

enum cudaError_t { cudaSuccess = 0, cudaErrorMemoryAllocation = 2 };
enum { cudaMemcpyHostToDevice, cudaMemcpyDeviceToHost };
static cudaError_t cudaMalloc(void **memory, size_t size)
{
  *memory = std::malloc(size);
  return *memory ? cudaSuccess : cudaErrorMemoryAllocation;
}
static cudaError_t cudaFree(void *memory) { std::free(memory); return cudaSuccess; }
static cudaError_t cudaMemcpy(void *to, const void *from, size_t size, int)
{
  std::memcpy(to, from, size);
  return cudaSuccess;
}
static cudaError_t cudaGetLastError() { return cudaSuccess; }
static cudaError_t cudaGetDeviceCount(int *count) { *count = 1; return cudaSuccess; }
static const char *cudaGetErrorString(cudaError_t) { return "no error"; }

template <class Kernel, class... Arguments>
static void launch(Kernel kernel, unsigned blocks, unsigned threads, Arguments... arguments)
{
  for (unsigned block = 0; block < blocks; ++block) {
    std::barrier<> all(threads);
    together = &all;
    std::vector<std::thread> running;
    for (unsigned thread = 0; thread < threads; ++thread)
      running.emplace_back([=] {
        threadIdx.x = thread, blockIdx.x = block, blockDim.x = threads;
        kernel(arguments...);
      });
    for (std::thread &one : running) one.join();
  }
}
