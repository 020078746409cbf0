# %% [markdown]
# **1.** Read from `located` the kinetic energies just before and just after the first impact. Which
# share is left? Reach **0.5586**.

# %%
before, after = located["kinetic"][struck[0] - 1], located["kinetic"][struck[0]]
answer = after / before

# %% [markdown]
# **2.** The percussion is oblique. How much friction does Housner's block need, so that its corner
# does not slip in an impact? It is the ratio of the two parts. Reach **0.3212**.

# %%
answer = abs(located["floor.force_x"][struck[0]] / located["floor.force_y"][struck[0]])

# %% [markdown]
# **3.** Tilt the block by twice as much. When does the first impact come, in ms? It is not when it
# came before: a rocking block has no period of its own. Reach **10.07**. (Tilted by more than its
# corner bears, it falls through the floor, as the end of the run tells: only its base is named.)

# %%
tilt = radians(0.02)
twice = rock(until=0.012, locate_impacts=True)
tilt = radians(0.01)
answer = 1e3 * twice.time[np.flatnonzero(twice["dt"][1:] == 0)[0] + 1]

# %% [markdown]
# **4.** Uniform steps round each impact to a step. Halve `dt` from $4\cdot10^{-5}$ to
# $2\cdot10^{-5}$ s: by which factor does the error of the impact times fall, about? Reach **2** (to
# a digit: first order).

# %%
answer = round(errors(rock(dt=4e-5))[1] / errors(uniform)[1])
