# %% [markdown]
# **1.** With impacts located the law of velocities is of second order. Halve its step to 2.5 ms: by
# which factor does the error fall, about? Reach **4**.

# %%
finer = rock("velocity", dt=2.5e-3, locate_impacts=True)
answer = round(worst(located) / worst(finer))

# %% [markdown]
# **2.** LAGRANGE at the corners and GAP on the whole base: how much do their kinetic energies
# differ, at most, in J? For a rigid block with a straight base the corners are enough. Reach
# **0.000**.

# %%
answer = np.abs(runs["gap"]["kinetic"] - runs["lagrange"]["kinetic"]).max()

# %% [markdown]
# **3.** Springs of a hundredth of the stiffness and a tenth of the damping: how deep does
# the block penetrate, in mm?
# Reach **0.09**.

# %%
FORMULATIONS["soft"] = (Discrete(stiffness=1e8, damping=4e5, points=corners), ThetaScheme(1.0))
answer = 1e3 * rock("soft")["floor.penetration"].max()
