"""Let threads of a kernel wait for each other, so that one launch does what would take thousands."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

import warp as wp

# A block waits for the others by counting in global memory. It works because all blocks run at the same time, so a
# kernel that uses it may have no more blocks than the device has multiprocessors.
_WAIT = """
#if defined(__CUDA_ARCH__)
    __syncthreads();
    if (blocks > 1) {
        if (threadIdx.x == 0) {
            const int wanted = (passed + 1) * blocks;
            __threadfence();
            atomicAdd(counter.data, 1);
            while (*reinterpret_cast<volatile int*>(counter.data) < wanted) {}
            __threadfence();
        }
        __syncthreads();
    }
#endif
    return passed + 1;
"""
# All threads of the block wait for each other, too.
_ANY = """
#if defined(__CUDA_ARCH__)
    return __syncthreads_or(value);
#else
    return value;
#endif
"""


@wp.func_native(_WAIT)
def wait_for_all(counter: wp.array[wp.int32], blocks: int, passed: int) -> int: ...


@wp.func_native(_ANY)
def any_of_block(value: int) -> int: ...
