"""
The engine in a C++ program
===========================

A program of thirty lines has the time loop in its own hands; Python, with the same scene, has the same flow.
"""

# %%
# The engine is a set of C++ libraries with headers, a CMake package and a file for pkg-config
# (:doc:`/embedding`, :doc:`reference </reference/cpp>`). Here a larynx of soft tissue is blown open; the
# program writes time and flow of each step.

import os
import shutil
import subprocess
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import plica

folder = Path(tempfile.mkdtemp())
(folder / "mine.cpp").write_text(
    r"""
#include <iostream>
#include <plica/dynamics/simulation.hpp>
#include <plica/mesh/larynx.hpp>

int main() {
  const plica::TetMesh mesh = plica::larynx_mesh(plica::Larynx::coarse());
  const plica::Material soft{plica::Isotropic{10e3, 0.4}, 1020.0, 1.0};  // Pa, -, kg/m^3, Pa s
  plica::Supports supports(mesh.node_count());
  for (const auto node : mesh.node_set("wall")) supports.fix(node);
  plica::Scene scene{mesh, {{soft}, {"soft"}, plica::Indices::Zero(mesh.cell_count())}, supports};
  scene.airflow.emplace().flow.subglottal_pressure = 800.0;  // Pa
  plica::Simulation simulation(scene, {plica::HilberHughesTaylor{}, 50e-6});
  std::cout.precision(17);
  while (simulation.time() < 10e-3) {
    simulation.advance();  // your own code has the state here, and may change its forces
    std::cout << simulation.time() << ' ' << simulation.record().flow->state.flow << '\n';
  }
}
"""
)

# %%
# It is compiled against an installed engine: one at ``PLICA_PREFIX``, or that of the clone in which this is
# run, as :doc:`/embedding` builds it.

prefix = Path(os.environ.get("PLICA_PREFIX", folder / "plica"))
clones = [Path.cwd(), *Path.cwd().parents]
built = next((one / "build/release" for one in clones if (one / "build/release/plica.pc").is_file()), None)
if not (prefix / "lib/pkgconfig/plica.pc").is_file() and built is not None:
    install = ["cmake", "--install", built, "--component", "development", "--prefix", prefix]
    subprocess.run(install, check=True, stdout=subprocess.DEVNULL)

compiler = shutil.which("g++")
has_engine = (prefix / "lib/pkgconfig/plica.pc").is_file()
from_cpp = None
if compiler is None or not has_engine or shutil.which("pkg-config") is None:
    print("Not compiled: g++, pkg-config or an installed engine is missing. Python alone is shown.")
else:
    asked = ["pkg-config", "--cflags", "--libs", "plica"]
    found = {**os.environ, "PKG_CONFIG_PATH": str(prefix / "lib/pkgconfig")}
    flags = subprocess.run(asked, check=True, capture_output=True, text=True, env=found).stdout.split()
    subprocess.run([compiler, "-O2", folder / "mine.cpp", *flags, "-o", folder / "mine"], check=True)
    said = subprocess.run([folder / "mine"], check=True, capture_output=True, text=True).stdout
    from_cpp = np.array([[float(number) for number in line.split()] for line in said.splitlines()])

# %%
# The same in Python, and how far both flows are apart.

soft = plica.Tissue(E="10 kPa", nu=0.4, viscosity="1 Pa s")
scene = plica.Scene(
    plica.Larynx(larynx="coarse"),
    {"body": soft, "ligament": soft, "cover": soft},
    airflow=plica.Airflow(subglottal_pressure="0.8 kPa"),
    time=plica.Stepping(step="50 us", duration="10 ms"),
)
from_python = plica.build_simulation(scene).advance(scene.time.steps)
print(f"Python: peak flow {1e6 * from_python['flow'].max():.3f} ml/s")
if from_cpp is not None:
    apart = np.abs(from_cpp[:, 1] - from_python["flow"]).max()
    print(f"C++:    peak flow {1e6 * from_cpp[:, 1].max():.3f} ml/s; {1e6 * apart:.1g} ml/s apart at most")

# %%
figure, axes = plt.subplots(figsize=(7, 3.5))
axes.plot(1e3 * from_python["time"], 1e6 * from_python["flow"], lw=4, alpha=0.4, label="Python")
if from_cpp is not None:
    axes.plot(1e3 * from_cpp[:, 0], 1e6 * from_cpp[:, 1], "k:", label="C++")
axes.set_xlabel("time (ms)")
axes.set_ylabel("flow (ml/s)")
axes.legend()
figure.tight_layout()
