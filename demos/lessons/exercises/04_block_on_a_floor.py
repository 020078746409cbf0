# %% [markdown]
# **1.** Where friction is 0.2, how far from the middle does the block still stick? Half-way from
# the outermost point of status 1 to the next one, which slips; the answer is as sure as points are
# apart, 0.03 m here. Reach **0.234** m.

# %%
_, contact, _ = pressed[0.2]
off = np.abs(contact.surface.points[:, 0])
answer = 0.5 * (off[contact.status == 1].max() + off[contact.status == 2].min())

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
