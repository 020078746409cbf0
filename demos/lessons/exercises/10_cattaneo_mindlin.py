# %% [markdown]
# **1.** How many points slip, how many stick? Give the share of the bearing points that stick.
# Reach **0.62**.

# %%
answer = np.count_nonzero(status == 1) / np.count_nonzero(status > 0)

# %% [markdown]
# **2.** Push half as far. Which share of $\mu P$ is the force now? It is a little more than
# half of what it was: what sticks is stiffer. Reach **0.33**.

# %%
answer = of_theory(push(shift=0.0235 / 2)[0])[1].utilisation

# %% [markdown]
# **3.** Push in one step instead of four: by how much, relative, does the tangential force change?
# Reach **0.00**.

# %%
answer = of_theory(push(steps=1)[0])[1].tangential_load / sheared.tangential_load - 1
