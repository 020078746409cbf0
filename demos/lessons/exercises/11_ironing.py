# %% [markdown]
# **1.** What friction takes is lost; what the slab takes, which is elastic, it gives back. How
# large is the drag without friction, over the normal force, in size? (What is left of it is the
# mesh's.) Reach **0.000**.

# %%
*_, smooth = iron(friction=0.0)
answer = abs(smooth["joint.force_x"][-1] / smooth["joint.force_y"][-1])

# %% [markdown]
# **2.** How many Newton iterations does a step take in the mean, with the geometry within each?
# Reach **3.9**.

# %%
answer = history["newton"][1:].mean()

# %% [markdown]
# **3.** Press to 0.1 instead of 0.05. By which factor does the normal force grow, at the end of
# pressing? Reach **2.5**.

# %%
*_, deep = iron(depth=0.1, until=5)
answer = deep["joint.force_y"][5] / history["joint.force_y"][5]
