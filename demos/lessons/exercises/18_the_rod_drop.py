# %% [markdown]
# **1.** Bent by 5 mm, friction 0.3: by how many ms is the rod late? Half of what 10 mm make is 4.8.
# Reach **2.8**.

# %%
answer = 1e3 * (drop(5e-3, 0.3).time_at(dashpot) - T5)

# %% [markdown]
# **2.** Another formulation, `formulation="lagrange"`, with 10 mm and friction 0.3: by how many ms
# does T5 differ, in size? Reach **0.0**.

# %%
other = drop(10e-3, 0.3, formulation="lagrange")
answer = 1e3 * abs(other.time_at(dashpot) - ways[10e-3, 0.3].time_at(dashpot))

# %% [markdown]
# **3.** A rod is 5 ms late, and its guide is bent by 20 mm. How large is friction? No further drop
# is needed. Reach **0.05**.

# %%
answer = 0.3 * 5e-3 / delays[20e-3, 0.3]
