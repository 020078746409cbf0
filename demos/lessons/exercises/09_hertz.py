# %% [markdown]
# **1.** How many nodes bear? Count the positive pressures of `contact`. Reach **23**.

# %%
answer = np.count_nonzero(contact.multiplier < 0)

# %% [markdown]
# **2.** Half the elements: by how many per cent is the peak off now? Reach **0.5**.

# %%
coarse, _, top = compare(press(0.058, n=5)[0])
answer = 100 * abs(top / coarse.peak_pressure - 1)

# %% [markdown]
# **3.** Press half as deep. By Hertz the half width is in proportion to the root of the load. By
# which factor has the load fallen? It is not in proportion to the depth. Reach **2.1**.

# %%
light = press(0.029)[0]
answer = contact.force[:, 1].sum() / light.force[:, 1].sum()
