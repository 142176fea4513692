# usdsdg in a container:
#
#   docker build --target cpu -t usdsdg .          docker run --rm -v "$PWD:/data" usdsdg generate detection.yaml
#   docker build --target cuda -t usdsdg-cuda .    docker run --rm --gpus all -v "$PWD:/data" usdsdg-cuda doctor
#
# On CUDA the driver is that of the host, which NVIDIA's container toolkit brings; Warp has all else. Kernels for GPUs are
# compiled at the first run, into the folder of WARP_CACHE_PATH: give it a volume to keep them.
FROM python:3.12-slim-bookworm AS base
ENV PIP_NO_CACHE_DIR=1 \
    PIP_DISABLE_PIP_VERSION_CHECK=1 \
    PYTHONDONTWRITEBYTECODE=1 \
    WARP_CACHE_PATH=/opt/usdsdg/kernels \
    XDG_CACHE_HOME=/opt/usdsdg/cache
# Open Image Denoise needs libatomic, which slim images lack.
# hadolint ignore=DL3008
RUN apt-get update && apt-get install -y --no-install-recommends libatomic1 && rm -rf /var/lib/apt/lists/*
RUN useradd --create-home --uid 1000 usdsdg && install -d -o usdsdg /opt/usdsdg /data
COPY . /tmp/source
RUN pip install "/tmp/source[denoise,meshes,stores,parquet]" && rm -rf /tmp/source
USER 1000
# Kernels are for the kind of processor that compiles them; on another they are compiled again.
RUN usdsdg warmup --device cpu --quiet && usdsdg doctor
WORKDIR /data
ENTRYPOINT ["usdsdg"]
CMD ["--help"]

FROM base AS cuda
ENV NVIDIA_VISIBLE_DEVICES=all \
    NVIDIA_DRIVER_CAPABILITIES=compute,utility

FROM base AS cpu
