# %% [markdown]
# **1.** Bent by 20 mm, but without friction: how much later than in free fall does the rod arrive,
# in ms? Bending it takes work, too, but little. Reach **0.3**.

# %%
answer = 1e3 * (arrival(drop(20e-3, friction=0.0)) - free)

# %% [markdown]
# **2.** Double the friction, 0.6, bent by 20 mm: when does it arrive? Reach **0.824** s.

# %%
answer = arrival(drop(20e-3, friction=0.6))

# %% [markdown]
# **3.** How much does the step matter? Halve it, with 20 mm and friction 0.3: by how many ms does
# the time of arrival change, in size? Reach **0.1**. (0.05 ms of it is the longer way of
# $\theta = 0.6$, which the straight rod has, too.)

# %%
answer = abs(1e3 * (arrival(drop(20e-3, dt=5e-4)) - arrival(bent)))
