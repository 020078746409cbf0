# SPDX-License-Identifier: LGPL-3.0-or-later
# fenicsx_contact on Debian 12, set up once by ./run, which is the entry point:
#
#   docker build -t fenicsx_contact .
#   docker run fenicsx_contact demos/rocking_block.py --quick
FROM debian:12-slim

# the packages that ./run asks for, a test holds both lists against each other
RUN apt-get update && DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends \
        python3-dolfinx python3-gmsh python3-meshio python3-matplotlib python3-scipy python3-tqdm \
        python3-pytest python3-pytest-xdist python3-hypothesis python3-venv libegl1 mpi-default-bin \
        libopenblas0-serial python3-h5py \
    && rm -rf /var/lib/apt/lists/*

COPY . /fenicsx_contact
WORKDIR /fenicsx_contact
RUN ./run -c "import fenicsx_contact"
ENTRYPOINT ["./run"]
