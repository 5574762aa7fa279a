import json
import subprocess
import sys

# Imports every module of core where Blender's modules are forbidden; prints what was imported of
# the packages that must wait for their use.
PROGRAM = """
import importlib, json, pkgutil, sys

class Forbid:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in {"bpy", "mathutils", "bmesh", "gpu", "aud", "bpy_extras", "bl_math", "idprop"}:
            raise ImportError(f"core imports {name}")

sys.meta_path.insert(0, Forbid())
import haptic_tracing.core as core
modules = [module.name for module in pkgutil.walk_packages(core.__path__, core.__name__ + ".")]
for name in modules:
    importlib.import_module(name)
early = sorted({"fcl", "hid", "hidraw", "networkx", "scipy", "fastjsonschema", "soxr"} & set(sys.modules))
print(json.dumps({"modules": modules, "early": early}))
"""


def test_core_imports_without_blender_and_without_native_packages():
    answer = subprocess.run([sys.executable, "-I", "-c", PROGRAM], capture_output=True, text=True)
    assert answer.returncode == 0, answer.stderr
    imported = json.loads(answer.stdout)
    assert "haptic_tracing.core.graph.haptic_graph" in imported["modules"]
    assert imported["early"] == []
