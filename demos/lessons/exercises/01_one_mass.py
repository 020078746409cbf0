# %% [markdown]
# **1.** How high does the mass rise after its first impact with $e = 0.7$? Say it first, then read
# it from `bounce`. Reach **0.245** m.

# %%
first = np.flatnonzero(bounce["dt"][1:] == 0)[0] + 1
answer = bounce["height"][first:].max()

# %% [markdown]
# **2.** It bounces infinitely often and yet rests after a finite time. When? The impacts are a
# geometric series: $t_\infty = \sqrt{2h/g}\,(1+e)/(1-e)$. Run until 2 s and find when it last moved
# faster than a millimetre in a second. Reach **1.81** s.

# %%
long = fall(Restitution(coefficient=0.7), until=2.0, dt=0.001, locate_impacts=True)
answer = long.time[np.abs(long["v"]) > 1e-3].max()

# %% [markdown]
# **3.** The law of positions rebounded because the step must end on the floor, so from the height
# $d$ at its start $v^+ = -v^- - 2d/\Delta t$ by $\theta = 1/2$. Show that $\theta = 1$ cures this:
# how high does the mass rise then, after 0.4 s? Reach **0.0000** m. (Lesson 3 tells what this
# costs.)

# %%
from fenicsx_contact import ThetaScheme

damped = fall("gap", scheme=ThetaScheme(1.0))
answer = damped["height"][damped.time > 0.4].max()

# %% [markdown]
# **4.** By hand: how many iterates does Newton's method need from $\lambda = 30$ N when $\rho_n$ is
# a thousand times $m/\Delta t$? And a thousandth of it? The equation has a kink, but both its
# branches are straight. Reach **2** for the larger.

# %%
answer = len(newton(30.0, -0.2, dt, 1000 * m / dt))
print(len(newton(30.0, -0.2, dt, 0.001 * m / dt)))
