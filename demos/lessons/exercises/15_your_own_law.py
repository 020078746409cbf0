# %% [markdown]
# **1.** Write Tresca's law: $b = s$ wherever it bears, whatever presses, here $s = 20$ Pa on 1 m².
# How far does the block come? It is $m v_0^2/2s$. Reach **0.250** m.

# %%


@dataclass(frozen=True)
class Tresca:
    stress: float  # Pa

    def bound(self, k, pressure, S):
        return self.stress * S * k.loaded

    def describe(self):
        return f"Tresca, {self.stress} Pa"


answer = throw(Tresca(20.0))["s"][-1]

# %% [markdown]
# **2.** A floor that becomes rough: $\mu = 0.6 + x/\mathrm{m}$, with $x$ the place of each point
# now, `k.place[0]`; the base begins between -0.5 and 0.5 m. How far does the block come? The mean
# of $\mu$ would say 0.080 m; but friction below its centre loads the front more, where it is
# rougher. Reach **0.076** m.


# %%
@dataclass(frozen=True)
class Rougher:
    def bound(self, k, pressure, S):
        return (0.6 + k.place[0]) * pressure

    def describe(self):
        return "a floor that becomes rough"


answer = throw(Rougher())["s"][-1]

# %% [markdown]
# **3.** The weakening of a fault: friction falls from 0.6 to 0.2 over 1 cm of slip, and stays. How
# far does the block come? Reach **0.245** m. (The energy: $\tfrac12 m v_0^2$ is $mg(0.2\,s +
# 0.4\cdot\tfrac12\cdot 0.01\,\mathrm m)$.)


# %%
@dataclass(frozen=True)
class Weakening:
    def bound(self, k, pressure, S):
        way = k.state("way", 0.0, lambda old, time: old + k.slip_speed * time)
        return (0.2 + 0.4 * ufl.max_value(1 - way / 0.01, 0.0)) * pressure

    def describe(self):
        return "slip weakening"


answer = throw(Weakening())["s"][-1]
