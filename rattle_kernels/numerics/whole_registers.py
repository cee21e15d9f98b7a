"""Vectors as wide as the processor's registers, in whatever program kernels are compiled.

LLVM uses half of the registers of Intel processors with AVX-512, since the first of these slowed their clock down for
whole ones. From Ice Lake on they do not. A feature of the target would change that for all of a process, and only
before Numba is loaded. So each function says itself what it prefers (docs/decisions/0032-whole-registers.md).
"""

import os
from typing import Any

import llvmlite.binding as llvm
from numba.core.compiler import Compiler, CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import PassManager, register_pass
from numba.core.lowering import Lower
from numba.core.typed_passes import BaseNativeLowering, NativeLowering

_TARGET = "NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES"
# The first processors with AVX-512 lack it: Skylake, Cascade Lake and Cooper Lake.
_SINCE_ICE_LAKE = "avx512vbmi2"


class _WholeLower(Lower):
    def setup_function(self, fndesc: Any) -> None:
        super().setup_function(fndesc)
        # llvmlite refuses attributes that it does not list. Of those with a value it lists none.
        set.add(self.function.attributes, '"prefer-vector-width"="512"')


@register_pass(mutates_CFG=True, analysis_only=False)
class _WholeLowering(BaseNativeLowering):
    _name = "lowering_in_whole_registers"
    lowering_class = _WholeLower


class _InWholeRegisters(CompilerBase):
    def define_pipelines(self) -> list[PassManager]:
        usual = DefaultPassBuilder.define_nopython_pipeline(self.state)
        usual.passes = [(_WholeLowering if each is NativeLowering else each, told) for each, told in usual.passes]
        usual.finalize()
        return [usual]


def compiler() -> type[CompilerBase]:
    """Numba's compiler, or one that prefers whole registers. The choice is the user's who has named a target."""
    chosen = any(name in os.environ for name in _TARGET)
    later = llvm.get_host_cpu_features().get(_SINCE_ICE_LAKE, False)
    return _InWholeRegisters if later and not chosen else Compiler
