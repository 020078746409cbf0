# %% [markdown]
# **1.** Released at 0.75 mm, where does it rest? Say it first: it turns at -0.55, 0.35, and so on.
# Reach **0.050** mm, in size.

# %%
answer = abs(1e3 * swing(start=0.75e-3)["x"][-1])

# %% [markdown]
# **2.** Which force does friction bear once the mass sticks? It is the spring's, not $\mu N$.
# Reach **0.50** N on the mass.

# %%
answer = run["floor.force_x"][-1]

# %% [markdown]
# **3.** Take only ten steps to half a period: by how many µm is the first turning point off?
# Reach **0.24**.

# %%
answer = 1e3 * (turns(swing(steps=10), steps=10)[0] + 0.65)

# %% [markdown]
# **4.** How large must the friction be for the mass never to move? Try values about it.
# Reach **0.85**.

# %%
still = [
    mu for mu in np.arange(0.80, 0.90, 0.01) if np.ptp(swing(friction=mu, halves=1)["x"]) < 1e-9
]
answer = min(still)
