# %% [markdown]
# **1.** Where friction is 0.2, how far from the middle does the block still stick? Read the
# outermost point of status 1. Reach **0.219** m.

# %%
_, contact, _ = pressed[0.2]
answer = np.abs(contact.surface.points[contact.status == 1, 0]).max()

# %% [markdown]
# **2.** Without friction the block becomes wider by $\nu(1+\nu)\,p/E$ times its width (plane
# strain). How much is that in mm? Read it from the displacements of its side. Reach **0.390** mm.

# %%
block, _, _ = pressed[0.0]
answer = 1e3 * np.ptp(block.displacement[::2])

# %% [markdown]
# **3.** Press in one step instead of ten, with friction 0.2: the pressure grows in proportion to
# the load, so the way of loading makes little difference here. By how much, at most, do the
# pressures differ, in units of the load? Reach **0.000**.

# %%
_, once, _ = press(0.2, steps=1)
_, slowly, _ = pressed[0.2]
answer = np.abs(once.multiplier - slowly.multiplier).max() / load
