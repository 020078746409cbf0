# %% [markdown]
# **1.** By how many mm does the top of the upper square go down? Both are squeezed evenly:
# $2p(1-\nu^2)/E$, one after the other. Reach **1.820**.

# %%
above, below, _ = press(7, 11)
answer = -1e3 * above.displacement[1::2].min()

# %% [markdown]
# **2.** Exchange the meshes, 11 above 7: is the patch test passed too? Give the largest error of
# the pressure, relative. Reach **0.000000**.

# %%
answer = np.abs(pressures(press(11, 7)[2])[1] / load - 1).max()

# %% [markdown]
# **3.** And with friction between the two, 0.3? Both want to widen by as much, so nothing slips and
# friction bears nothing. Give the largest tangential force over the load. Reach **0.000000**.

# %%
answer = np.abs(press(7, 11, friction=0.3)[2].force[:, 0]).max() / load

# %% [markdown]
# **4.** Does node-to-segment get better with finer meshes? Take 70 cells above 110: by how much
# are its forces off now? Reach **0.57**.

# %%
answer = np.abs(node_to_segment(70, 110)[1] - 1).max()
