# The command line and all nodes in one image: docker build -t ama . && docker run --rm -v "$PWD:/data" ama info recording.mcap
FROM python:3.12-slim-bookworm AS build
RUN apt-get update && apt-get install -y --no-install-recommends g++ make && rm -rf /var/lib/apt/lists/*
COPY . /source
WORKDIR /source
RUN make wheels WHEELS=/wheels PYTHON=python3

FROM python:3.12-slim-bookworm
COPY --from=build /wheels /wheels
RUN pip install --no-cache-dir "$(ls /wheels/autonomous_modal_analysis-*.whl)[ros,tables,parquet,plots,hdf,batch]" \
    /wheels/oma_msgs-*.whl /wheels/tf2_msgs-*.whl /wheels/control_msgs-*.whl && rm -r /wheels
# Two BLAS threads make the small LAPACK calls of modal analysis slower than one.
ENV OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1 MKL_NUM_THREADS=1
RUN useradd --create-home ama && mkdir /data && chown ama /data
USER ama
WORKDIR /data
ENTRYPOINT ["ama"]
CMD ["--help"]
